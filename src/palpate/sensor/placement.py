"""Where one frame stands in another, and the tilt of a wall from its normal."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray


def _unturned() -> FloatArray:
    return np.eye(3)


def _unmoved() -> FloatArray:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a frame stands in another: ``base_from_flange @ flange_from_sensor`` is ``base_from_sensor``.

    Attributes
    ----------
    rotation
        (3, 3) its axes as columns.
    position
        (3,) its origin, mm.

    Examples
    --------
    >>> lifted = Placement(position=np.array([0.0, 0.0, 100.0]))
    >>> lifted.apply(np.array([1.0, 0.0, 0.0])).tolist()
    [1.0, 0.0, 100.0]
    """

    rotation: FloatArray = field(default_factory=_unturned)
    position: FloatArray = field(default_factory=_unmoved)

    def __matmul__(self, other: Placement) -> Placement:
        return Placement(self.rotation @ other.rotation, self.apply(other.position))

    def apply(self, point: FloatArray) -> FloatArray:
        """A point (3,) mm of this frame in the other."""
        return self.rotation @ point + self.position

    def inverse(self) -> Placement:
        """Where the other frame stands in this one."""
        return Placement(self.rotation.T, -self.rotation.T @ self.position)

    def moved(self, by: FloatArray) -> Placement:
        """The same frame, its origin moved by (3,) mm along the axes of the other."""
        return Placement(self.rotation, self.position + by)


def rotation_from_vector(vector_deg: FloatArray) -> FloatArray:
    """Rotation (3, 3) by a rotation vector (3,) in degrees."""
    return Rotation.from_rotvec(vector_deg, degrees=True).as_matrix()


def rotation_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """The shortest rotation (3, 3) that takes one unit vector (3,) to another; they are not opposite.

    Examples
    --------
    >>> (rotation_between(np.array([1.0, 0, 0]), np.array([0, 1.0, 0])) @ [1.0, 0.0, 0.0]).round(9).tolist()
    [0.0, 1.0, 0.0]
    """
    axis, cosine = np.cross(first, second), float(first @ second)
    skew = np.cross(np.eye(3), axis)
    return np.eye(3) + skew + skew @ skew / (1.0 + cosine)


def tilt_from_normal(normal: FloatArray) -> FloatArray:
    """Rotation vector (rx, ry), degrees, of a wall with this unit normal (3,): the inverse of `wall_normal`.

    Examples
    --------
    >>> from palpate.design import wall_normal
    >>> tilt_from_normal(wall_normal(*np.radians([3.0, -4.0]))).round(9).tolist()
    [3.0, -4.0]
    """
    across = float(np.hypot(normal[0], normal[1]))
    if across == 0.0:
        return np.zeros(2)
    return np.degrees(np.arctan2(across, normal[2])) / across * np.array([-normal[1], normal[0]])
