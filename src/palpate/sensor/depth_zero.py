"""Depth zero: position of first contact on the robot's scale.

The model estimates the depth since first contact. A robot has its own scale, and its assumed position of first
contact is wrong by some tenths of a millimetre or more (1 mm in the paper). One press determines the offset: the
median over its images of the robot's depth minus the sensor's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError

LEAST_IMAGES = 3
"""Minimum number of images for a zero. By hand."""


@dataclass(frozen=True)
class DepthZero:
    """Offset of the sensor's depth zero on another scale.

    Attributes
    ----------
    offset, spread
        Depth on that scale at first contact, mm, to be added to the sensor's depth; median absolute deviation of
        images.
    images
        Number of images used.
    """

    offset: float
    spread: float
    images: int


def find_depth_zero(estimated: FloatArray, other: FloatArray, min_depth: float = 2.4) -> DepthZero:
    """Determine the depth zero from depths (n,) mm by the sensor and by the robot, of one press.

    Estimates that are not finite or below `min_depth`, the minimum of the model's training data, are ignored.

    Raises
    ------
    PalpateError
        If fewer than three images remain.

    Examples
    --------
    >>> sensor, robot = np.array([2.5, 3.5, 4.5]), np.array([3.5, 4.4, 5.6])
    >>> round(find_depth_zero(sensor, robot).offset, 6)
    1.0
    """
    counts = np.isfinite(estimated) & np.isfinite(other) & (np.nan_to_num(estimated) >= min_depth)
    if counts.sum() < LEAST_IMAGES:
        raise PalpateError(
            f"{counts.sum()} images deeper than {min_depth:g} mm do not determine the depth zero.",
            f"Press deeper and record at least {LEAST_IMAGES} images.",
            code="depth-zero-unknown",
        )
    apart = other[counts] - estimated[counts]
    offset = float(np.median(apart))
    return DepthZero(offset, float(np.median(np.abs(apart - offset))), int(counts.sum()))
