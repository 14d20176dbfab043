"""Pose of a wall: tilt and azimuth, rotation vector, normal, and rotations about the axis.

A wall is rotated by a rotation vector (rx, ry, 0) = tilt (cos azimuth, sin azimuth, 0). The azimuth is the direction
of the rotation axis, seen from above, from x towards y. At azimuth 0 the wall rises towards +y.
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray


def rotation_vector(tilt: ArrayLike, azimuth: ArrayLike) -> FloatArray:
    """Return components (..., 2) of the rotation vector, in the unit of the tilt; azimuth in rad.

    Examples
    --------
    >>> rotation_vector(5.0, np.pi / 2).round(9).tolist()
    [0.0, 5.0]
    """
    return np.stack([tilt * np.cos(azimuth), tilt * np.sin(azimuth)], axis=-1)


class PoseDensity(StrEnum):
    """Distribution of samples over tilts, or over offsets from the axis."""

    UNIFORM_TILT = "uniform_tilt"
    """Uniform in tilt."""
    UNIFORM_DISC = "uniform_disc"
    """Uniform by area of the disc of poses, so large tilts are more frequent."""

    def radius(self, share: ArrayLike, reach: float, inner: float = 0.0) -> FloatArray:
        """Return radii (...) from `inner` to `reach`, in their unit, for uniform shares (...) from 0 to 1.

        Examples
        --------
        >>> [float(density.radius(0.25, 12.0)) for density in PoseDensity]
        [3.0, 6.0]
        """
        share = np.asarray(share, float)
        if self is PoseDensity.UNIFORM_DISC:
            return np.sqrt(inner**2 + (reach**2 - inner**2) * share) if inner else reach * np.sqrt(share)
        return inner + (reach - inner) * share


def wall_normal(rx: float, ry: float) -> FloatArray:
    """Return the outward normal (3,) of the wall for its rotation vector (rx, ry) in radians.

    ``n = cos(t) e_z + sin(t) (ry, -rx, 0) / t`` with ``t = |(rx, ry)|``: e_z rotated by the rotation vector.

    Examples
    --------
    >>> wall_normal(np.radians(30), 0.0).round(3).tolist()
    [0.0, -0.5, 0.866]
    """
    tilt = float(np.hypot(rx, ry))
    if tilt == 0.0:
        return np.array([0.0, 0.0, 1.0])
    return np.array([np.sin(tilt) * ry / tilt, -np.sin(tilt) * rx / tilt, np.cos(tilt)])


def turn_about_axis(azimuth: float) -> FloatArray:
    """Return the rotation (3, 3) about z by an angle in rad, ``turned_from_plain``.

    Its columns are the axes of the rotated frame.

    Examples
    --------
    >>> (turn_about_axis(np.pi / 2) @ [1.0, 0.0, 0.0]).round(9).tolist()
    [0.0, 1.0, 0.0]
    """
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
