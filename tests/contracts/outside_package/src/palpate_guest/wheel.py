"""A rigid wheel with a round tyre that rolls along y: an obstacle from outside."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from palpate.core import FloatArray, IntArray, parameter
from palpate.fea import ObstacleSpec, find_first_contact
from palpate.mechanics import Gap, Obstacle, grid_quads
from palpate.mesh import Mesh


@dataclass(frozen=True)
class Wheel(Obstacle):
    """A torus about x: ``delta = r - |q|`` with ``q = (x, sqrt(y² + z²) - R)``."""

    radius: float
    tyre: float
    point: FloatArray

    def moved(self, by: FloatArray) -> Self:
        return type(self)(self.radius, self.tyre, self.point + by)

    def gap(self, points: FloatArray) -> Gap:
        x, y, z = (points - self.point).T
        out = np.hypot(y, z)
        away = np.stack([np.zeros_like(y), y / out, z / out], axis=-1)
        q = np.stack([x, out - self.radius], axis=-1)
        length = np.linalg.norm(q, axis=1)
        normal = -(x[:, None] * np.array([1.0, 0.0, 0.0]) + q[:, 1:] * away) / length[:, None]
        flat = np.diag([0.0, 1.0, 1.0]) - away[:, :, None] * away[:, None, :]
        plane = np.diag([1.0, 0.0, 0.0]) + away[:, :, None] * away[:, None, :]
        bend = -(plane - normal[:, :, None] * normal[:, None, :]) / length[:, None, None]
        return Gap(self.tyre - length, normal, bend - (q[:, 1] / length / out)[:, None, None] * flat)

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        around, across = np.meshgrid(
            np.linspace(-1, 1, 21) * half / (self.radius + self.tyre),
            np.linspace(-1, 1, 21) * min(1.0, half / self.tyre),
        )
        out = self.radius + self.tyre * np.cos(across)
        place = np.stack([-self.tyre * np.sin(across), out * np.sin(around), -out * np.cos(around)], axis=-1)
        return (self.point + place).reshape(-1, 3), grid_quads(21, 21)


class WheelSpec(ObstacleSpec):
    """A wheel brought down along the axis, its own axis along x."""

    kind: Literal["wheel"] = "wheel"
    radius: float = parameter(8.0, unit="mm", meaning="radius of the tyre's middle line", gt=0, le=100)
    tyre: float = parameter(3.0, unit="mm", meaning="radius of the tyre's section", gt=0, le=100)

    offset: float = parameter(0.0, unit="mm", meaning="distance of the wheel's centre from the axis", ge=0, le=60)

    @property
    def label(self) -> str:
        return f"wheel {self.radius:g} mm"

    @property
    def radial(self) -> float:
        return self.offset

    @property
    def turn_deg(self) -> float:
        return -90.0

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        above = mesh.skin.outer_height + self.radius + self.tyre
        return find_first_contact(mesh, Wheel(self.radius, self.tyre, np.array([0.0, self.offset, above])))
