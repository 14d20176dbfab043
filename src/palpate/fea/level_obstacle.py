"""Common parameters of obstacles that lie level across a skin: bars and edges."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from palpate.core import FloatArray, parameter
from palpate.design import PoseSpace, turn_about_axis
from palpate.fea.first_contact import find_first_contact
from palpate.fea.spec import ObstacleSpec
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh


class LevelObstacleSpec(ObstacleSpec, ABC):
    """A rigid obstacle parallel to the base, uniform along its length, that moves along the skin's axis."""

    offset: float = parameter(0.0, unit="mm", meaning="distance of its axis from the skin's", ge=-60, le=60)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction in which it lies; it is offset to the left of it", ge=-360, le=360
    )

    @abstractmethod
    def place(self, point: FloatArray, along: FloatArray) -> Obstacle:
        """Return the obstacle whose axis passes through a point (3,) mm along a unit vector (3,)."""

    @property
    @abstractmethod
    def half_height(self) -> float:
        """Height of its axis over its lowest line, mm."""

    @property
    def pose_space(self) -> PoseSpace:
        return PoseSpace.for_lines()

    @property
    def radial(self) -> float:
        return self.offset

    @property
    def turn_deg(self) -> float:
        return self.azimuth_deg

    @property
    def axisymmetric(self) -> bool:
        return False

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        turn = turn_about_axis(np.radians(self.azimuth_deg if mesh.spec.whole else 0.0))
        middle = turn @ [0.0, self.offset, self.half_height + mesh.skin.outer_height]
        return find_first_contact(mesh, self.place(middle, turn[:, 0].copy()))
