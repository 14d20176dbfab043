"""A flat wall at the side of a barrel: a rigid plane that moves along its normal from first contact.

::

     ||  |=.
     ||  |  \\         tilt 90°: touched halfway
     ||  |   |
     ||  |  /          tilt 90° + d: by the radius of the arc times sin d nearer to the rim
         |=.

Its pose is that of a wall: the rotation vector (rx, ry) = tilt (cos azimuth, sin azimuth), and the depth, here along
the normal.
"""

from __future__ import annotations

from typing import Literal, final

import numpy as np

from palpate.core import FloatArray, PalpateError, parameter
from palpate.design import PoseSpace, Rim, Skin, rotation_vector, wall_normal
from palpate.fea.spec import ObstacleSpec
from palpate.fea.wall import Plane
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh


@final
class SideWallSpec(ObstacleSpec):
    """A rigid flat wall at the side of a skin that moves along its own normal."""

    kind: Literal["side_wall"] = "side_wall"
    tilt_deg: float = parameter(90.0, unit="deg", meaning="angle between wall normal and skin axis", ge=60, le=120)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction of the rotation axis: (rx, ry) = tilt (cos, sin)", ge=-360, le=360
    )

    @property
    def sideways(self) -> bool:
        return True

    @property
    def label(self) -> str:
        return f"side wall of tilt {self.tilt_deg:g}°"

    @property
    def pose_space(self) -> PoseSpace:
        return PoseSpace.for_side_walls()

    @property
    def radial(self) -> float:
        return self.tilt_deg

    @property
    def turn_deg(self) -> float:
        return self.azimuth_deg

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        normal = self.approach_axis(mesh)
        touched = mesh.skin.support_point(normal)
        return Plane(normal, touched), touched

    def approach_axis(self, mesh: Mesh) -> FloatArray:
        """Return the wall's normal, as described in `ObstacleSpec`.

        Raises
        ------
        PalpateError
            If the skin is not a barrel, or the wall touches a clamped end first.
        """
        self.check_skin(mesh.skin, mesh.spec.rim)
        azimuth = np.radians(self.azimuth_deg) if mesh.spec.whole else 0.0
        return wall_normal(*rotation_vector(np.radians(self.tilt_deg), azimuth))

    def check_skin(self, skin: Skin, rim: Rim = Rim.FLAT) -> None:
        if not skin.hole:
            raise PalpateError(
                f"A side wall requires a barrel; {skin.name} is not one.",
                "Press it along its axis, by a wall with a tilt of up to 30°.",
                code="side-wall-needs-barrel",
            )
        most = np.degrees(skin.rim_slope(rim))
        if not 180 - most < self.tilt_deg < most:
            raise PalpateError(
                f"A wall tilted by {self.tilt_deg:.3g}° touches a clamped end of {skin.name} first.",
                f"Tilt it by more than {180 - most:.1f}° and less than {most:.1f}°.",
                code="side-wall-touches-end",
            )

    def clamp_depth(self, mesh: Mesh) -> float:
        return mesh.skin.clamp_depth(np.radians(self.tilt_deg), mesh.spec.rim)
