"""The flat wall: a rigid plane turned by (rx, ry) that moves along the skin's axis from first touch.

A robot's wall drifts a little as it comes down: sideways in its own plane, and turning about its normal. Both are
proportional to the depth, and change nothing but what sticks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Self, final

import numpy as np
from pydantic import SerializerFunctionWrapHandler, model_serializer
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray, IntArray, PalpateError, kernel, parameter
from palpate.design import TILT_DEPTH, PoseSpace, rotation_vector, wall_normal
from palpate.fea.spec import ObstacleSpec, descended
from palpate.mechanics import Gap, Obstacle, tangents
from palpate.mesh import Mesh


@final
class WallSpec(ObstacleSpec):
    """A rigid flat wall turned by a tilt about an axis of the base plane and moved along the dome's axis."""

    tilt_deg: float = parameter(0.0, unit="deg", meaning="angle between wall normal and dome axis", ge=0, le=30)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction of the rotation axis: (rx, ry) = tilt (cos, sin)", ge=-360, le=360
    )

    DRIFTS: ClassVar[tuple[str, ...]] = ("drift", "drift_across", "twist_rate_deg")
    """Fields, and names of derivatives, by which it moves other than along the skin's axis."""

    drift: float = parameter(
        0.0, unit="mm/mm", meaning="travel in the wall's plane, up or down its slope, over depth", ge=-1, le=1
    )
    drift_across: float = parameter(0.0, unit="mm/mm", meaning="the same across the slope", ge=-1, le=1)
    twist_rate_deg: float = parameter(
        0.0, unit="deg/mm", meaning="turn about the wall's normal over depth", ge=-5, le=5
    )

    @model_serializer(mode="wrap")
    def _leave_out_drift(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A wall that does not drift is written as before there was drift, so that artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        return {name: value for name, value in content.items() if name not in self.DRIFTS or value}

    @property
    def drifts(self) -> bool:
        """Whether it moves other than along the skin's axis."""
        return any(getattr(self, name) for name in self.DRIFTS)

    @property
    def words(self) -> str:
        return f"tilt {self.tilt_deg:g}°" + (" that drifts" if self.drifts else "")

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

    def path(self, mesh: Mesh) -> Callable[[float], Obstacle]:
        touched, _ = self.at_touch(mesh)
        if not self.drifts:
            return partial(descended, touched)
        if not mesh.spec.whole and (self.drift_across or self.twist_rate_deg):
            raise PalpateError(
                f"A wall that drifts by {self.drift_across:g} mm/mm across its slope, or turns by "
                f"{self.twist_rate_deg:g}°/mm, is not symmetric.",
                "Use a whole mesh: MeshSpec(whole=True).",
            )
        assert isinstance(touched, Plane)
        along, across = slope_ways(touched.normal, np.radians(self.azimuth_deg) if mesh.spec.whole else 0.0)
        way = self.drift * along + self.drift_across * across
        return partial(drifting, partial(descended, touched), way, np.radians(self.twist_rate_deg))

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
    axes
        (3, 3) its own axes as columns, once it has turned about its normal.
    """

    normal: FloatArray
    point: FloatArray
    axes: FloatArray | None = None

    def moved(self, by: FloatArray) -> Self:
        return type(self)(self.normal, self.point + by, self.axes)

    def twisted(self, angle: float) -> Self:
        """The plane turned about its normal by an angle in rad: it stays where it is, what sticks to it turns."""
        axes = np.eye(3) if self.axes is None else self.axes
        return type(self)(self.normal, self.point, Rotation.from_rotvec(angle * self.normal).as_matrix() @ axes)

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
        place = points - self.point - reach[:, None] * self.normal
        return reach, place if self.axes is None else place @ self.axes


def slope_ways(normal: FloatArray, azimuth: float) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (3,) in a wall's plane along its slope and across it; its tilt's axis is at an azimuth in rad."""
    across = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    return np.cross(normal, across), across


def drifting(wall: Callable[[float], Obstacle], way: FloatArray, twist: float, depth: float) -> Plane:
    """A wall at a depth in mm that goes the `way` (3,) mm/mm besides, and turns by `twist` rad/mm."""
    plane = wall(depth)
    assert isinstance(plane, Plane)
    return plane.moved(depth * way).twisted(depth * twist)


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
