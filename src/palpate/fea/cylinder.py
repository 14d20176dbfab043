"""A rigid cylinder."""

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
class Cylinder(Obstacle):
    """A rigid cylinder without ends: the gap is that of a ball in the plane across its axis.

    `point` (3,) mm is a point of its axis, `axis` (3,) a unit vector along it.
    """

    radius: float
    point: FloatArray
    axis: FloatArray

    def moved(self, by: FloatArray) -> Self:
        return type(self)(self.radius, self.point + by, self.axis)

    def gap(self, points: FloatArray) -> Gap:
        return round_gap(self.point - points, self.radius, np.eye(3) - np.outer(self.axis, self.axis))

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        foot = self.point + ((at - self.point) @ self.axis) * self.axis
        inward = (foot - at) / self.radius
        across = np.cross(inward, self.axis)
        angle = np.linspace(-1, 1, PATCH) * min(half / self.radius, np.pi / 2)
        way = np.sin(angle)[:, None, None] * across - np.cos(angle)[:, None, None] * inward
        along = np.linspace(-half, half, 2)[None, :, None] * self.axis
        return (foot + self.radius * way + along).reshape(-1, 3), grid_quads(PATCH, 2)


@final
class CylinderSpec(LevelObstacleSpec):
    """A rigid bar parallel to the base that moves along the skin's axis, at an offset from it."""

    kind: Literal["cylinder"] = "cylinder"
    radius: float = parameter(5.0, unit="mm", meaning="radius of the bar", gt=0, le=1000)

    @property
    def label(self) -> str:
        return f"cylinder {self.radius:g} mm, {self.offset:g} mm off the axis"

    @property
    def half_height(self) -> float:
        return self.radius

    def place(self, point: FloatArray, along: FloatArray) -> Cylinder:
        return Cylinder(self.radius, point, along)
