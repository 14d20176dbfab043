"""Check of a recorded image: it is neither blank nor saturated, and the camera is not frozen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Source
from palpate.core import PalpateError
from palpate.rig.take_spec import ImageCheckSpec, TakeSpec

_TOPS = (1023, 4095, 16383)
"""Maximum grey values of cameras of 10, 12 and 14 bits, whose images are stored in 16."""
_BLOCK = 4
"""Side of blocks, px; their means vary little in the noise of a covered lens. By hand."""
NextImage = Callable[[], NDArray[Any] | PalpateError]
"""Return an image taken after the call, or an error if none could be taken."""


class Exposure(NamedTuple):
    """Maximum grey value, share of pixels at it, and standard deviation of means of blocks over it."""

    top: float
    saturated: float
    spread: float


def measure_exposure(image: NDArray[Any]) -> Exposure:
    """Measure the exposure of an image (h, w) or (h, w, 3) of integers of 8 to 16 bits."""
    most = np.iinfo(image.dtype).max
    top = float(next((top for top in _TOPS if image.max() <= top < most), most))
    rows, columns = (side - side % _BLOCK for side in image.shape[:2])
    blocks = image[:rows, :columns].reshape(rows // _BLOCK, _BLOCK, columns // _BLOCK, -1)
    return Exposure(top, float((image >= top).mean()), float(blocks.mean(axis=(1, 3)).std()) / top)


def find_image_fault(image: NDArray[Any], before: NDArray[Any] | None, spec: ImageCheckSpec) -> str:
    """Return the fault of an image (h, w) or (h, w, 3), the end of a sentence, or an empty text.

    `before` is the image of another pose, which a frozen camera repeats.

    Examples
    --------
    >>> find_image_fault(np.zeros((8, 8), np.uint8), None, TakeSpec())
    'is blank: its standard deviation is 0 of 255'
    """
    if not np.issubdtype(image.dtype, np.integer):
        return f"has values of type {image.dtype}, not integers"
    top, share, spread = measure_exposure(image)
    if share > spec.saturated:
        return f"is saturated at {share:.0%} of its pixels"
    if spread < spec.blank:
        return f"is blank: its standard deviation is {spread * top:.2g} of {top:g}"
    if before is not None and np.array_equal(image, before):
        return "equals that of another pose: the camera is frozen"
    return ""


def take_image(
    next_image: NextImage, before: NDArray[Any] | None, spec: TakeSpec, *, again: bool = True
) -> NDArray[Any]:
    """Return the next image without a fault; one with a fault is taken again once, if `again`.

    Raises
    ------
    PalpateError
        If the last image has a fault, or is missing.
    """
    image = next_image()
    if isinstance(image, PalpateError):
        error = image
    elif fault := find_image_fault(image, before, spec):
        error = PalpateError(
            f"An image of this pose, taken twice, {fault}.",
            "Check camera and light; start the same command again.",
            code="image-rejected",
        )
    else:
        return image
    if again:
        return take_image(next_image, before, spec, again=False)
    raise error


def images_of(source: Source, buffered: int) -> NextImage:
    """Return a function that takes the next image of a source, after those that a live camera buffered."""
    images = source.images()
    ended = PalpateError(f"{source.name} has no more images.", "Start the same command again.", code="source-gone")

    def take() -> NDArray[Any] | PalpateError:
        try:
            for _ in range(buffered if source.live else 0):
                next(images, None)
            return next(images, ended)
        except Exception as error:  # a camera's library may raise anything
            return PalpateError.of(error)

    return take
