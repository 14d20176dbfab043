"""A rigid plate with a hole, tilted like a wall, whose hole may have a countersink.

Holes are re-drilled and deburred, so a sensor is pressed over them. In a plane through the axis of the hole, with
the distance r from that axis and the height h into the plate, the profile is convex::

    h |            |#######
      |            |#######    wall of the hole, r = R
      |             \\######
      |              \\#####    countersink
      |_______________\\####______
      0                                r

Its corners are rounded: the body is the set of points within the edge radius of a smaller one. The
penetration is ``e - d`` at a distance d from the nearest corner of that one, and the depth below its nearest edge
elsewhere. Value and gradient are continuous up to a penetration of the edge radius.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, Self, final

import numpy as np
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from palpate.core import FloatArray, IntArray, PalpateError, parameter
from palpate.design import TILT_SPACE, PoseSpace, Rim, Skin, rotation_vector, wall_normal
from palpate.fea.ball import PATCH
from palpate.fea.first_contact import find_first_contact
from palpate.fea.spec import ObstacleSpec
from palpate.fea.wall import refuse_rim_first, slope_ways
from palpate.mechanics import Gap, Obstacle, grid_quads, tangents
from palpate.mesh import Mesh


@final
@dataclass(frozen=True)
class Plate(Obstacle):
    """A rigid plate with a hole.

    Attributes
    ----------
    point, normal
        (3,) mm, intersection of the axis of the hole and the surface of the plate; (3,) unit normal into the plate.
    radius, edge_radius
        Radius of the hole, and of its rounded corners, mm.
    sink_radius, sink_angle
        Radius of the countersink at the surface, mm, or of the hole if it is not sunk; angle between flank and axis,
        rad.
    """

    point: FloatArray
    normal: FloatArray
    radius: float
    edge_radius: float
    sink_radius: float
    sink_angle: float

    @property
    def corners(self) -> FloatArray:
        """(2, 2) mm, r and h of the centres of the rounded corners at the surface and at the wall of the hole."""
        edge, half = self.edge_radius, self.sink_angle
        sunk = (self.sink_radius - self.radius) / np.tan(half)
        if not sunk:
            return np.full((2, 2), [self.radius + edge, edge])
        outer = self.radius + (edge - np.sin(half) * (edge - sunk)) / np.cos(half)
        return np.array([[outer, edge], [self.radius + edge, sunk + edge * (1.0 - np.cos(half)) / np.sin(half)]])

    def moved(self, by: FloatArray) -> Self:
        return replace(self, point=self.point + by)

    def gap(self, points: FloatArray) -> Gap:
        arm = points - self.point
        height = arm @ self.normal
        aside = arm - height[:, None] * self.normal
        distance = np.maximum(np.linalg.norm(aside, axis=1), np.spacing(self.radius))
        outward = aside / distance[:, None]
        outer, inner = self.corners
        steepest = np.array([np.cos(self.sink_angle), np.sin(self.sink_angle)])
        place = np.column_stack([distance, height])
        before, past = ((place - corner) @ [-steepest[1], steepest[0]] for corner in (outer, inner))
        surface = distance >= outer[0]
        rim = ~surface & (before <= 0)
        flank = ~surface & ~rim & (past <= 0)
        lip = ~surface & ~rim & ~flank & (height < inner[1])
        slope, reach = np.tile([1.0, 0.0], (len(points), 1)), distance - self.radius  # wall of the hole
        slope[surface], reach[surface] = [0.0, 1.0], height[surface]
        slope[flank], reach[flank] = steepest, self.edge_radius + (place[flank] - outer) @ steepest
        for here, corner in ((rim, outer), (lip, inner)):
            away = place[here] - corner
            far = np.linalg.norm(away, axis=1)
            slope[here], reach[here] = -away / far[:, None], self.edge_radius - far
        around = np.cross(self.normal, outward)
        bend = (slope[:, 0] / distance)[:, None, None] * around[:, :, None] * around[:, None, :]
        arc = np.where(rim | lip, reach, -np.inf) - self.edge_radius  # -inf: not bent in this plane
        along = slope[:, :1] * self.normal - slope[:, 1:] * outward
        bend += along[:, :, None] * along[:, None, :] / arc[:, None, None]
        return Gap(reach, slope[:, :1] * outward + slope[:, 1:] * self.normal, bend)

    def depth_below(self, points: FloatArray) -> FloatArray:
        """Return the depth (n,) mm below the surface of the plate, as if the hole were filled."""
        return np.asarray((points - self.point) @ self.normal)

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        """Return the plate around its hole to `half` beyond `at`, and the wall of the hole as deep."""
        outer, inner = self.corners
        way = [np.array([np.sin(turn), np.cos(turn)]) for turn in np.linspace(0.0, np.pi / 2, PATCH // 2)]
        steepest = np.array([np.cos(self.sink_angle), np.sin(self.sink_angle)])
        arcs = [
            corner - self.edge_radius * np.array([side, up])
            for corner, chosen in ((outer, 0), (inner, 1))
            for side, up in way
            if chosen == (side > steepest[0])
        ]
        reach = float(np.linalg.norm(at - self.point - ((at - self.point) @ self.normal) * self.normal)) + half
        profile = np.array([[max(reach, outer[0] + half), 0.0], *arcs, [self.radius, inner[1] + half]])
        along, across = tangents(self.normal)
        turn = np.linspace(0.0, 2.0 * np.pi, PATCH)
        wheel = np.cos(turn)[:, None] * along + np.sin(turn)[:, None] * across
        points = self.point + profile[:, None, :1] * wheel + profile[:, None, 1:] * self.normal
        return np.concatenate(points), grid_quads(len(profile), PATCH)


@final
class PlateSpec(ObstacleSpec):
    """A rigid plate with a hole, tilted about an axis of the base plane and moved along the skin's axis.

    The axis of the skin meets the plate at the middle of the hole, or at the offsets from it.
    """

    kind: Literal["plate"] = "plate"
    tilt_deg: float = parameter(0.0, unit="deg", meaning="angle between plate normal and skin axis", ge=0, le=30)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction of the rotation axis: (rx, ry) = tilt (cos, sin)", ge=-360, le=360
    )
    hole_diameter: float = parameter(5.0, unit="mm", meaning="diameter of the hole", gt=0, le=100)
    edge_radius: float = parameter(
        0.2, unit="mm", meaning="radius by which the edge of the hole is rounded", gt=0, le=20
    )
    sink_diameter: float = parameter(
        0.0, unit="mm", meaning="diameter of the countersink at the surface; 0: no countersink", ge=0, le=200
    )
    sink_angle_deg: float = parameter(
        100.0, unit="deg", meaning="angle of the countersink between its flanks", ge=40, le=140
    )
    offset: float = parameter(
        0.0, unit="mm", meaning="offset of the hole up the slope of the plate, from the skin's axis", ge=-60, le=60
    )
    offset_across: float = parameter(
        0.0, unit="mm", meaning="offset of the hole along the tilt axis of the plate", ge=-60, le=60
    )

    @model_validator(mode="after")
    def _edges_fit_the_countersink(self) -> Self:
        if self.sink_diameter:
            outer, inner = self._plate(np.empty(0), np.empty(0)).corners
            if self.sink_diameter <= self.hole_diameter or outer[0] <= inner[0]:
                raise PydanticCustomError(
                    "countersink-too-small",
                    "A countersink of {sink} mm does not fit a hole of {hole} mm with edges rounded by {edge} mm; "
                    "use a larger countersink, or smaller edges.",
                    {"sink": self.sink_diameter, "hole": self.hole_diameter, "edge": self.edge_radius},
                )
        return self

    @property
    def label(self) -> str:
        sunk = f" sunk to {self.sink_diameter:g} mm" if self.sink_diameter else ""
        off = f", {self.offset:g} and {self.offset_across:g} mm off" if self.offset or self.offset_across else ""
        return f"plate with a hole of {self.hole_diameter:g} mm{sunk}, tilt {self.tilt_deg:g}°{off}"

    @property
    def pose_space(self) -> PoseSpace:
        return TILT_SPACE

    @property
    def mirrored(self) -> bool:
        return not self.offset_across

    @property
    def centred(self) -> bool:
        return not (self.offset or self.offset_across)

    @property
    def axisymmetric(self) -> bool:
        return False

    @property
    def radial(self) -> float:
        return self.tilt_deg

    @property
    def turn_deg(self) -> float:
        return self.azimuth_deg

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        """Return the plate at first contact, as described in `ObstacleSpec`.

        Raises
        ------
        PalpateError
            If it touches the clamped rim first.
        """
        refuse_rim_first(mesh, self.tilt_deg)
        azimuth = np.radians(self.azimuth_deg) if mesh.spec.whole else 0.0
        normal = wall_normal(*rotation_vector(np.radians(self.tilt_deg), azimuth))
        up, across = slope_ways(normal, azimuth)
        middle = np.array([0.0, 0.0, mesh.skin.outer_height]) + self.offset * up + self.offset_across * across
        return find_first_contact(mesh, self._plate(middle, normal))

    def check_skin(self, skin: Skin, rim: Rim = Rim.FLAT) -> None:
        super().check_skin(skin, rim)
        widest = max(self.hole_diameter, self.sink_diameter)
        if widest >= 2.0 * skin.outer_base_radius:
            raise PalpateError(
                f"A hole of {widest:g} mm is as wide as {skin.name}, which does not touch the plate.",
                f"Use a hole of less than {2.0 * skin.outer_base_radius:.4g} mm.",
                code="obstacle-misses-skin",
            )

    def clamp_depth(self, mesh: Mesh) -> float:
        plate = self.at_first_contact(mesh)[0]
        assert isinstance(plate, Plate)
        surface = plate.point @ plate.normal / plate.normal[2]  # its height on the axis; a flat wall begins higher
        higher = float(mesh.skin.support_height(plate.normal[None])[0] - surface)
        return mesh.skin.clamp_depth(np.radians(self.tilt_deg), mesh.spec.rim) - higher

    def _plate(self, middle: FloatArray, normal: FloatArray) -> Plate:
        half = 0.5 * self.hole_diameter
        sink = max(0.5 * self.sink_diameter, half)
        return Plate(middle, normal, half, self.edge_radius, sink, np.radians(0.5 * self.sink_angle_deg))
