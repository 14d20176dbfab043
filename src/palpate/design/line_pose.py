"""Pose of a line across a skin, a bar or an edge of offset o and angle φ, by continuous numbers.

The lines (o, φ) and (-o, φ + 180°) are the same, so neither number alone can be estimated. Continuous and equal for
both descriptions are

    (x, y) = o (-sin φ, cos φ),    (c, s) = (90/π)° (cos 2φ, sin 2φ) :

the line's point nearest to the axis, and its doubled direction. The second is needed if the line passes near the
axis; rotation of the line by a small angle moves (c, s) by as many degrees.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray

LONGEST_DEG = 90.0 / np.pi
"""Length of the direction vector."""


def direction_vector(angle_deg: FloatArray) -> FloatArray:
    """Return the doubled directions (..., 2) in degrees of lines at angles (...) from x.

    Examples
    --------
    >>> direction_vector(np.array([0.0, 90.0, 180.0])).round(2).tolist()
    [[28.65, 0.0], [-28.65, 0.0], [28.65, -0.0]]
    """
    twice = 2.0 * np.radians(angle_deg)
    return LONGEST_DEG * np.stack([np.cos(twice), np.sin(twice)], axis=-1)


def offset_and_angle(poses: ArrayLike) -> FloatArray:
    """Return offset and angle (..., 2) of lines (..., 5) by `palpate.design.PoseSpace.for_lines`.

    The offset is in mm to the left of the direction, the direction's angle from x from -90° to 90°.

    Examples
    --------
    >>> offset_and_angle([0.0, 2.0, 4.0, *direction_vector(np.array(0.0))]).round(9).tolist()
    [2.0, 0.0]
    """
    poses = np.asarray(poses, float)
    angle = 0.5 * np.arctan2(poses[..., 4], poses[..., 3])
    offset = poses[..., 1] * np.cos(angle) - poses[..., 0] * np.sin(angle)
    return np.stack([offset, np.degrees(angle)], axis=-1)


def line_error(estimates: ArrayLike, poses: ArrayLike) -> FloatArray:
    """Return the errors (..., 2) of lines, offset (mm) and angle (degrees), for (..., 5) arguments.

    An estimate of 89° for a line at -89° has an error of 2°, and its offset is counted in the same direction.
    """
    found, true = offset_and_angle(estimates), offset_and_angle(poses)
    turned = found[..., 1] - true[..., 1]
    half_turns = np.round(turned / 180.0)
    offset = np.where(half_turns % 2 == 0, found[..., 0], -found[..., 0])
    return np.stack([offset - true[..., 0], turned - 180.0 * half_turns], axis=-1)
