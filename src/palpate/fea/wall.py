"""Flat wall: a rigid plane rotated by (rx, ry) that moves along the skin's axis from first contact.

The wall of a robot may also move laterally in its own plane and twist about its normal. Both are proportional to the
depth, and affect only points that stick. The wall may be curved: a large ball or bowl that is tangent to its plane at
the first-contact point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, Self, final

import numpy as np
from pydantic import SerializerFunctionWrapHandler, model_serializer

from palpate.core import FloatArray, IntArray, PalpateError, kernel, parameter
from palpate.design import TILT_SPACE, PoseSpace, rotation_vector, wall_normal
from palpate.fea.spec import ObstacleSpec, translate_obstacle
from palpate.mechanics import Gap, Obstacle, tangents
from palpate.mesh import Mesh


@final
class WallSpec(ObstacleSpec):
    """Rigid flat wall, tilted about an axis of the base plane and moved along the skin's axis."""

    tilt_deg: float = parameter(0.0, unit="deg", meaning="angle between wall normal and skin axis", ge=0, le=30)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction of the rotation axis: (rx, ry) = tilt (cos, sin)", ge=-360, le=360
    )

    LATERAL_FIELDS: ClassVar[tuple[str, ...]] = ("lateral_rate", "lateral_rate_across", "twist_rate_deg")
    """Fields, and names of derivatives, of lateral motion and twist."""

    lateral_rate: float = parameter(
        0.0, unit="mm/mm", meaning="lateral motion in the wall's plane along its slope, per depth", ge=-1, le=1
    )
    lateral_rate_across: float = parameter(
        0.0, unit="mm/mm", meaning="lateral motion in the wall's plane across its slope, per depth", ge=-1, le=1
    )
    twist_rate_deg: float = parameter(
        0.0, unit="deg/mm", meaning="twist about the wall normal, per depth", ge=-5, le=5
    )

    curvature: float = parameter(
        0.0, unit="1/m", meaning="curvature in all directions; positive: convex towards the skin", ge=-20, le=100
    )

    @model_serializer(mode="wrap")
    def _leave_out_nothing(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out zero lateral motion and curvature, so that a plain wall keeps its artefact keys."""
        content: dict[str, Any] = dump(self)
        return {
            name: value for name, value in content.items() if name not in (*self.LATERAL_FIELDS, "curvature") or value
        }

    @property
    def moves_laterally(self) -> bool:
        return any(getattr(self, name) for name in self.LATERAL_FIELDS)

    @property
    def mirrored(self) -> bool:
        return not (self.lateral_rate_across or self.twist_rate_deg)

    @property
    def centred(self) -> bool:
        return not (self.lateral_rate or self.lateral_rate_across)

    @property
    def label(self) -> str:
        bent = f" of curvature {self.curvature:g}/m" if self.curvature else ""
        return f"tilt {self.tilt_deg:g}°" + bent + (" that drifts" if self.moves_laterally else "")

    @property
    def pose_space(self) -> PoseSpace:
        return TILT_SPACE

    @property
    def radial(self) -> float:
        return self.tilt_deg

    @property
    def turn_deg(self) -> float:
        return self.azimuth_deg

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        normal = self.normal(mesh)
        touched = mesh.skin.support_point(normal)
        return Plane(normal, touched, curvature=1e-3 * self.curvature), touched

    def path(self, mesh: Mesh) -> Callable[[float], Obstacle]:
        touched, _ = self.at_first_contact(mesh)
        down = partial(translate_obstacle, touched, self.approach_axis(mesh))
        if not self.moves_laterally:
            return down
        assert isinstance(touched, Plane)
        along, across = slope_ways(touched.normal, np.radians(self.azimuth_deg) if mesh.spec.whole else 0.0)
        way = self.lateral_rate * along + self.lateral_rate_across * across
        return partial(drifting, down, way, np.radians(self.twist_rate_deg))

    def normal(self, mesh: Mesh) -> FloatArray:
        """Return the outward normal (3,) in the frame of the mesh: a half model lies in the tilt plane.

        Raises
        ------
        PalpateError
            If the wall touches the clamped rim before the skin.
        """
        refuse_rim_first(mesh, self.tilt_deg)
        tilt, azimuth = np.radians(self.tilt_deg), np.radians(self.azimuth_deg) if mesh.spec.whole else 0.0
        return wall_normal(*rotation_vector(tilt, azimuth))

    def clamp_depth(self, mesh: Mesh) -> float:
        return mesh.skin.clamp_depth(np.radians(self.tilt_deg), mesh.spec.rim)


@final
@dataclass(frozen=True)
class Plane(Obstacle):
    """A rigid half space, ``delta = n·(x - p)``; with a curvature b, a ball of radius 1/b tangent in p.

    Attributes
    ----------
    normal, point
        (3,) unit normal away from the body, and (3,) mm a point that moves with the plane.
    axes
        (3, 3) its own axes as columns, if it has twisted about its normal.
    curvature
        1/mm; negative: concave.
    """

    normal: FloatArray
    point: FloatArray
    axes: FloatArray | None = None
    curvature: float = 0.0

    def moved(self, by: FloatArray) -> Self:
        return replace(self, point=self.point + by)

    def twisted(self, angle: float) -> Self:
        """Return the plane rotated about its normal at `point` by an angle in rad, with the points that stick."""
        from scipy.spatial.transform import Rotation  # here: its import takes half a second

        axes = np.eye(3) if self.axes is None else self.axes
        return replace(self, axes=Rotation.from_rotvec(angle * self.normal).as_matrix() @ axes)

    def gap(self, points: FloatArray) -> Gap:
        if self.curvature:
            return _bent_gap(points - self.point, self.normal, self.curvature)
        return Gap(_height(points, self.point, self.normal), np.tile(self.normal, (len(points), 1)), None)

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        along, across = tangents(self.normal)
        if self.curvature:
            raise PalpateError(
                "A curved wall has no flat facets.",
                "Press with a ball of its radius instead.",
                code="wall-bent-no-facets",
            )
        sides = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        return np.array([at + half * (a * along + b * across) for a, b in sides]), np.array([[0, 1, 2, 3]])

    def penetration(self, points: FloatArray) -> FloatArray:
        if self.curvature:
            return super().penetration(points)
        reach: FloatArray = (points - self.point) @ self.normal
        return reach

    def closest_points(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        if self.curvature:
            return super().closest_points(points)
        reach = self.penetration(points)
        place = points - self.point - reach[:, None] * self.normal
        return reach, place if self.axes is None else place @ self.axes


def refuse_rim_first(mesh: Mesh, tilt_deg: float) -> None:
    """Raise a `PalpateError` if a tilted flat wall touches the clamped rim before the skin."""
    rim = mesh.skin.rim_slope(mesh.spec.rim)
    if np.radians(tilt_deg) >= rim:
        raise PalpateError(
            f"A wall tilted by {tilt_deg:.3g}° touches the clamped rim (at {np.degrees(rim):.1f}° from the axis) "
            "before the skin.",
            "Reduce the tilt, or make the skin higher.",
            code="rim-touched-first",
        )


def slope_ways(normal: FloatArray, azimuth: float) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors (3,) along and across a wall's slope; its tilt axis is at an azimuth in rad."""
    across = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    return np.cross(normal, across), across


def drifting(obstacle: Callable[[float], Obstacle], way: FloatArray, twist: float, depth: float) -> Plane:
    """Return a wall at a depth in mm with lateral motion `way` (3,) mm/mm and `twist` rad/mm."""
    plane = obstacle(depth)
    assert isinstance(plane, Plane)
    return plane.moved(depth * way).twisted(depth * twist)


def _bent_gap(arm: FloatArray, normal: FloatArray, curvature: float) -> Gap:
    """Return the gap of a ball of radius ``1/curvature`` mm at vectors (n, 3) mm from its tangent point.

    The form is continuous at zero curvature.
    """
    height, square = arm @ normal, (arm**2).sum(axis=1)
    far = np.sqrt(1.0 - 2.0 * curvature * height + curvature**2 * square)  # distance from the centre over the radius
    way = (normal - curvature * arm) / far[:, None]
    hessian = (way[:, :, None] * way[:, None, :] - np.eye(3)) * (curvature / far)[:, None, None]
    return Gap((2.0 * height - curvature * square) / (1.0 + far), way, hessian)


@kernel
def _height(points: FloatArray, point: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the height (n,) mm of points over a plane, along its normal."""
    height = np.empty(len(points))
    x = np.empty(3)
    for k in range(len(points)):
        delta = 0.0
        for i in range(3):
            x[i] = points[k, i] - point[i]
            delta += normal[i] * x[i]
        height[k] = delta
    return height
