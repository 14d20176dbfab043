"""Check of a recorded image: it is neither blank nor saturated, and the camera is not frozen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Source
from palpate.core import PalpateError
from palpate.rig.take_spec import TakeSpec

NextImage = Callable[[], NDArray[Any] | PalpateError]
"""Return an image taken after the call, or an error if none could be taken."""


def find_image_fault(image: NDArray[Any], before: NDArray[Any] | None, spec: TakeSpec) -> str:
    """Return the fault of an image (h, w) or (h, w, 3), a sentence, or an empty text.

    `before` is the image of another pose, which a frozen camera repeats.

    Examples
    --------
    >>> find_image_fault(np.zeros((8, 8), np.uint8), None, TakeSpec())
    'The image is blank.'
    """
    top = float(np.iinfo(image.dtype).max) if np.issubdtype(image.dtype, np.integer) else 1.0
    if float((image >= top).mean()) > spec.saturated:
        return "The image is saturated."
    if float(image.std()) < spec.blank * top:
        return "The image is blank."
    if before is not None and np.array_equal(image, before):
        return "The camera is frozen: two images of different poses are equal."
    return ""


def take_image(next_image: NextImage, before: NDArray[Any] | None, spec: TakeSpec) -> NDArray[Any]:
    """Return the next image without a fault; one with a fault is taken again once.

    Raises
    ------
    PalpateError
        If the second image has a fault or is missing, too.
    """
    fault = PalpateError("No image was taken.", code="image-rejected")
    for _ in range(2):
        image = next_image()
        if isinstance(image, PalpateError):
            fault = image
            continue
        found = find_image_fault(image, before, spec)
        if not found:
            return image
        fault = PalpateError(found, "Check camera and light; start the same command again.", code="image-rejected")
    raise fault


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
