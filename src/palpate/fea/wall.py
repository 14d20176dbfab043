"""The flat wall: a rigid plane turned by (rx, ry) that moves along the skin's axis from first touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self, final

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError, kernel, parameter
from palpate.design import TILT_DEPTH, PoseSpace, rotation_vector, wall_normal
from palpate.fea.spec import ObstacleSpec
from palpate.mechanics import Gap, Obstacle, tangents
from palpate.mesh import Mesh


@final
class WallSpec(ObstacleSpec):
    """A rigid flat wall turned by a tilt about an axis of the base plane and moved along the dome's axis."""

    tilt_deg: float = parameter(0.0, unit="deg", meaning="angle between wall normal and dome axis", ge=0, le=30)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction of the rotation axis: (rx, ry) = tilt (cos, sin)", ge=-360, le=360
    )

    @property
    def words(self) -> str:
        return f"tilt {self.tilt_deg:g}°"

    @property
    def pose_space(self) -> PoseSpace:
        return TILT_DEPTH

    @property
    def radial(self) -> float:
        return self.tilt_deg

    @property
    def turn_deg(self) -> float:
        return self.azimuth_deg

    def at_touch(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        normal = self.normal(mesh)
        touched = mesh.skin.touch(normal)
        return Plane(normal, touched), touched

    def normal(self, mesh: Mesh) -> FloatArray:
        """Outward normal (3,) in the frame of the mesh: a half model lies in the tilt plane.

        Raises
        ------
        PalpateError
            If the wall touches the clamped rim before the skin.
        """
        tilt, azimuth = np.radians(self.tilt_deg), np.radians(self.azimuth_deg) if mesh.spec.whole else 0.0
        rim = mesh.skin.rim_slope(mesh.spec.rim)
        if tilt >= rim:
            raise PalpateError(
                f"A wall tilted by {self.tilt_deg:g}° touches the clamped rim (at {np.degrees(rim):.1f}° from the "
                "axis) before the dome.",
                "Tilt it less, or make the dome higher.",
            )
        return wall_normal(*rotation_vector(tilt, azimuth))

    def clamp_depth(self, mesh: Mesh) -> float:
        return mesh.skin.clamp_depth(np.radians(self.tilt_deg), mesh.spec.rim)


@final
@dataclass(frozen=True)
class Plane(Obstacle):
    """A rigid half space: ``delta = n·(x - p)``.

    Attributes
    ----------
    normal
        (3,) unit normal, away from the body and into the half space.
    point
        (3,) mm, a point that moves with the plane.
    """

    normal: FloatArray
    point: FloatArray

    def moved(self, by: FloatArray) -> Self:
        return type(self)(self.normal, self.point + by)

    def gap(self, points: FloatArray) -> Gap:
        return Gap(_height(points, self.point, self.normal), np.tile(self.normal, (len(points), 1)), None)

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        along, across = tangents(self.normal)
        sides = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        return np.array([at + half * (a * along + b * across) for a, b in sides]), np.array([[0, 1, 2, 3]])

    def reach(self, points: FloatArray) -> FloatArray:
        reach: FloatArray = (points - self.point) @ self.normal
        return reach

    def foot(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        reach = self.reach(points)
        return reach, points - self.point - reach[:, None] * self.normal


@kernel
def _height(points: FloatArray, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Height (n,) mm of points over a plane, along its normal."""
    height = np.empty(len(points))
    x = np.empty(3)
    for k in range(len(points)):
        delta = 0.0
        for i in range(3):
            x[i] = points[k, i] - point[i]
            delta += normal[i] * x[i]
        height[k] = delta
    return height
