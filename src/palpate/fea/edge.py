"""A rigid edge: a wedge with a rounded ridge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self, final

import numpy as np

from palpate.core import FloatArray, IntArray, parameter
from palpate.fea.ball import PATCH, round_gap
from palpate.fea.level_obstacle import LevelObstacleSpec
from palpate.mechanics import Gap, Obstacle, grid_quads


@final
@dataclass(frozen=True)
class Edge(Obstacle):
    """A rigid wedge that points down: gap of a cylinder at its rounded ridge, of a plane at its flanks.

    `radius` is that of the rounding, `point` (3,) a point of its axis, mm; `axis` (3,) is the level unit vector along
    the ridge, `half_angle` the angle between each flank and the plane through the ridge, rad.
    """

    radius: float
    point: FloatArray
    axis: FloatArray
    half_angle: float

    @property
    def _sideways(self) -> FloatArray:
        return np.cross([0.0, 0.0, 1.0], self.axis)

    def moved(self, by: FloatArray) -> Self:
        return type(self)(self.radius, self.point + by, self.axis, self.half_angle)

    def gap(self, points: FloatArray) -> Gap:
        arm = points - self.point
        under = round_gap(-arm, self.radius, np.eye(3) - np.outer(self.axis, self.axis))
        sideways = arm @ self._sideways
        side = np.where(sideways < 0, -1.0, 1.0)[:, None]
        outward = side * np.cos(self.half_angle) * self._sideways - np.sin(self.half_angle) * np.array(
            [0.0, 0.0, 1.0]
        )
        # beyond the line on which the rounding ends, the flank is closer
        upward = side * np.sin(self.half_angle) * self._sideways + np.cos(self.half_angle) * np.array([0.0, 0.0, 1.0])
        beside = (arm * upward).sum(axis=1) > 0
        flank = self.radius - (arm * outward).sum(axis=1)
        bend = np.zeros((len(points), 3, 3)) if under.curvature is None else under.curvature
        return Gap(
            np.where(beside, flank, under.penetration),
            np.where(beside[:, None], -outward, under.normal),
            np.where(beside[:, None, None], 0.0, bend),
        )

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        """Return the rounding, then the flanks, up to `half` on either side along the surface."""
        foot = self.point + ((at - self.point) @ self.axis) * self.axis
        round_ = self.radius * (np.pi / 2 - self.half_angle)
        along = np.linspace(-min(round_, half), min(round_, half), PATCH)
        if half > round_:
            along = np.concatenate([[-half], along, [half]])
        angle = np.clip(along, -round_, round_) / self.radius
        rest = along - angle * self.radius
        down = np.array([0.0, 0.0, -1.0])
        way = np.sin(angle)[:, None] * self._sideways + np.cos(angle)[:, None] * down
        tangent = np.cos(angle)[:, None] * self._sideways - np.sin(angle)[:, None] * down
        profile = (foot + self.radius * way + rest[:, None] * tangent)[:, None]
        return (profile + np.linspace(-half, half, 2)[None, :, None] * self.axis).reshape(-1, 3), grid_quads(
            len(along), 2
        )


@final
class EdgeSpec(LevelObstacleSpec):
    """A rigid edge parallel to the base that moves along the skin's axis, at an offset from it."""

    kind: Literal["edge"] = "edge"
    radius: float = parameter(1.0, unit="mm", meaning="radius by which the edge is rounded", gt=0, le=100)
    opening_deg: float = parameter(90.0, unit="deg", meaning="angle between the flanks", ge=10, le=170)

    @property
    def label(self) -> str:
        return f"edge of {self.opening_deg:g}° rounded by {self.radius:g} mm, {self.offset:g} mm off the axis"

    @property
    def half_height(self) -> float:
        return self.radius

    def place(self, point: FloatArray, along: FloatArray) -> Edge:
        return Edge(self.radius, point, along, np.radians(self.opening_deg) / 2)
