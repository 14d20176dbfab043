"""Pose of one frame in another, and tilt of a wall from its normal."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray

if TYPE_CHECKING:
    from palpate.design import Skin


def _unturned() -> FloatArray:
    return np.eye(3)


def _unmoved() -> FloatArray:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class Placement:
    """Pose of a frame in another: ``base_from_flange @ flange_from_sensor`` is ``base_from_sensor``.

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
        """Transform a point (3,) mm of this frame to the outer frame."""
        return self.rotation @ point + self.position

    def inverse(self) -> Placement:
        """Return the pose of the outer frame in this one."""
        return Placement(self.rotation.T, -self.rotation.T @ self.position)

    def wall_pose(self, point: FloatArray, normal: FloatArray, skin: Skin, thickness: float = 0.0) -> FloatArray:
        """Return rx, ry (degrees) and depth (mm) of a flat wall under a sensor at this pose.

        `point` (3,) mm is on the wall and `normal` (3,) into it, in the outer frame; `thickness` (mm) is added to
        that of the skin. Without contact the depth is negative.
        """
        inward = self.rotation.T @ normal
        height = float(inward @ self.inverse().apply(point))
        reach = float(skin.support_point(inward) @ inward) + thickness
        return np.array([*tilt_from_normal(inward), (reach - height) / inward[2]])

    def moved(self, by: FloatArray) -> Placement:
        """Return the pose with its origin moved by (3,) mm along the axes of the outer frame."""
        return Placement(self.rotation, self.position + by)


def rotation_from_vector(vector_deg: FloatArray) -> FloatArray:
    """Return the rotation matrix (3, 3) of a rotation vector (3,) in degrees."""
    return Rotation.from_rotvec(vector_deg, degrees=True).as_matrix()


def rotation_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the shortest rotation (3, 3) from one unit vector (3,) to another, not opposite one.

    Examples
    --------
    >>> (rotation_between(np.array([1.0, 0, 0]), np.array([0, 1.0, 0])) @ [1.0, 0.0, 0.0]).round(9).tolist()
    [0.0, 1.0, 0.0]
    """
    axis, cosine = np.cross(first, second), float(first @ second)
    skew = np.cross(np.eye(3), axis)
    return np.eye(3) + skew + skew @ skew / (1.0 + cosine)


def tilt_from_normal(normal: FloatArray) -> FloatArray:
    """Return the tilt (rx, ry), degrees, of a wall with a unit normal (3,); inverse of `wall_normal`.

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
