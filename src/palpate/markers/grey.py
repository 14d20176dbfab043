"""Any image as one plane of single-precision grey levels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError

_LUMA = np.array([0.114, 0.587, 0.299], np.float32)
"""Weights of blue, green and red (ITU-R BT.601), in OpenCV's order."""
_SMALLEST_PX = 8


def to_grey(image: NDArray[Any], largest_mpx: float) -> NDArray[np.float32]:
    """Grey levels of an image.

    Parameters
    ----------
    image
        (h, w), (h, w, 1), (h, w, 3) or (h, w, 4) of any number type; colours in the order blue, green, red.
    largest_mpx
        Largest image that is taken, in millions of pixels.

    Returns
    -------
    ndarray
        (h, w) in the levels of the image.

    Raises
    ------
    PalpateError
        If it is no image, is smaller than 8 px, larger than allowed, or holds what is not a number.
    """
    image = np.asarray(image)
    colours = image.shape[2] if image.ndim == 3 else 1
    if image.ndim not in (2, 3) or colours not in (1, 3, 4) or image.dtype.kind not in "buif":
        raise PalpateError(
            f"An array of shape {image.shape} and type {image.dtype} is not an image.",
            "Give (h, w).",
            code="image-shape-wrong",
        )
    height, width = image.shape[:2]
    if min(height, width) < _SMALLEST_PX:
        raise PalpateError(
            f"The image has {width} × {height} px.",
            f"Give one of at least {_SMALLEST_PX} px a side.",
            code="image-too-small",
        )
    if height * width > largest_mpx * 1e6:
        raise PalpateError(
            f"The image has {width} × {height} px, more than {largest_mpx:g} million.",
            "Shrink it, or raise largest_mpx.",
            code="image-too-large",
        )
    if image.ndim == 3:
        image = image[..., 0] if colours == 1 else image[..., :3].astype(np.float32) @ _LUMA
    grey = np.ascontiguousarray(image, np.float32)
    if image.dtype.kind == "f" and not np.isfinite(grey).all():
        raise PalpateError(
            "The image holds values that are not numbers.", "Repair or leave it out.", code="image-not-finite"
        )
    return grey
