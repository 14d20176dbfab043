"""A rigid ball."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self, final

import numpy as np

from palpate.core import FloatArray, IntArray, parameter
from palpate.design import turn_about_axis
from palpate.fea.first_contact import find_first_contact
from palpate.fea.spec import ObstacleSpec
from palpate.mechanics import Gap, Obstacle, grid_quads, tangents
from palpate.mesh import Mesh

PATCH = 49
"""Points along each side of a patch. By hand."""
_WIDE = 1.0
"""Maximum angle (rad) from the middle of a ball's patch to its sides. By hand."""


@final
@dataclass(frozen=True)
class Ball(Obstacle):
    """A rigid ball: ``delta = r - |x - c|``, ``n = (c - x)/|x - c|``, Hessian ``-(I - n nᵀ)/|x - c|``.

    `point` (3,) is its centre; lengths in mm.
    """

    radius: float
    point: FloatArray

    def moved(self, by: FloatArray) -> Self:
        return type(self)(self.radius, self.point + by)

    def gap(self, points: FloatArray) -> Gap:
        return round_gap(self.point - points, self.radius, np.eye(3))

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        inward = (self.point - at) / self.radius
        along, across = tangents(inward)
        slope = np.tan(np.linspace(-1, 1, PATCH) * min(half / self.radius, _WIDE))
        way = slope[None, :, None] * along + slope[:, None, None] * across - inward
        way /= np.linalg.norm(way, axis=-1, keepdims=True)
        return (self.point + self.radius * way).reshape(-1, 3), grid_quads(PATCH, PATCH)


def round_gap(arm: FloatArray, radius: float, across: FloatArray) -> Gap:
    """Compute the gap of a ball or a cylinder.

    `arm` (n, 3) mm are the vectors from points to the centre or a point of the axis; `across` (3, 3) projects onto
    the directions in which it is round.
    """
    arm = arm @ across
    distance = np.maximum(np.linalg.norm(arm, axis=1), 1e-9 * radius)
    normal = arm / distance[:, None]
    bend = (normal[:, :, None] * normal[:, None, :] - across) / distance[:, None, None]
    return Gap(radius - distance, normal, bend)


@final
class BallSpec(ObstacleSpec):
    """A rigid ball that moves along the skin's axis, at an offset from it."""

    kind: Literal["ball"] = "ball"
    radius: float = parameter(5.0, unit="mm", meaning="radius of the ball", gt=0, le=1000)
    offset: float = parameter(0.0, unit="mm", meaning="distance of the ball's centre from the axis", ge=0, le=60)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction in which the ball lies from the axis", ge=-360, le=360
    )

    @property
    def label(self) -> str:
        return f"ball {self.radius:g} mm, {self.offset:g} mm off the axis"

    @property
    def radial(self) -> float:
        return self.offset

    @property
    def turn_deg(self) -> float:
        return self.azimuth_deg - 90.0

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        middle = self.turn(mesh).T @ turn_about_axis(np.radians(self.azimuth_deg)) @ [self.offset, 0.0, 0.0]
        if not mesh.spec.whole:
            middle[0] = 0.0
        middle[2] = self.radius + mesh.skin.outer_height
        return find_first_contact(mesh, Ball(self.radius, middle))
