"""The zero of the depth: where the dome was first touched, on the robot's scale.

The model tells the depth since first touch. A robot has a scale of its own, and where it believes to touch is off by
tenths of a millimetre or more; in the paper, by 1 mm. One press shows the difference: the median over its images
of the robot's depth less the sensor's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError

LEAST_IMAGES = 3
"""Images below which no zero is found."""


@dataclass(frozen=True)
class DepthZero:
    """Where the sensor's depth 0 lies on another scale.

    Attributes
    ----------
    offset
        Depth on the other scale at first touch, mm: add it to the sensor's depth.
    spread
        Median distance of single images from it, mm.
    images
        Number of images that it comes from.
    """

    offset: float
    spread: float
    images: int


def find_depth_zero(estimated: FloatArray, other: FloatArray, min_depth: float = 2.4) -> DepthZero:
    """Find the zero from one press.

    Parameters
    ----------
    estimated
        (n,) mm, depths by the sensor; those that are not numbers or below `min_depth` do not count.
    other
        (n,) mm, depths of the same images by the robot.
    min_depth
        Depth from which the model was trained, mm.

    Raises
    ------
    PalpateError
        If fewer than three images count.

    Examples
    --------
    >>> sensor, robot = np.array([2.5, 3.5, 4.5]), np.array([3.5, 4.4, 5.6])
    >>> round(find_depth_zero(sensor, robot).offset, 6)
    1.0
    """
    counts = np.isfinite(estimated) & np.isfinite(other) & (np.nan_to_num(estimated) >= min_depth)
    if counts.sum() < LEAST_IMAGES:
        raise PalpateError(
            f"{counts.sum()} images deeper than {min_depth:g} mm do not give the depth's zero.",
            f"Press deeper and record at least {LEAST_IMAGES} images.",
            code="depth-zero-unknown",
        )
    apart = other[counts] - estimated[counts]
    offset = float(np.median(apart))
    return DepthZero(offset, float(np.median(np.abs(apart - offset))), int(counts.sum()))
