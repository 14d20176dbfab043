"""Barrel: a bulging tube of revolution, clamped at both ends and pressed from the side, like TacLINK.

     far end, z = H  |=.              .=|
                     |  \\            /  |
                     |   |  (inside) |   |      both surfaces arcs about one centre
                     |  /            \\  |
         rim, z = 0  |=.              .=|
                            camera

Both ends are open, so the meridian begins at the far end instead of an apex, and the disc has a hole: the ring
``HOLE <= s <= 1`` maps both surfaces.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal, Self, final

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray, PalpateError, parameter
from palpate.design.outline import Arc, Outline
from palpate.design.ray import trace_rays
from palpate.design.skin import Rim, Skin, Symmetry
from palpate.design.spec import SkinSpec

HOLE = 0.25
"""Radius of the far end's circle on the unit disc. By hand."""
_LEAST_BULGE = 1e-6
"""Minimum ratio of bulge to length; below it, the arc's centre is so distant that rounding matters."""
_TACLINK = "mesh of the authors' SimTacLS"


@final
class BarrelSpec(SkinSpec):
    """Barrel between two clamps; the defaults are those of TacLINK (Duong & Ho 2021)."""

    kind: Literal["barrel"] = "barrel"
    height: float = parameter(
        260.0, unit="mm", meaning="length between the two clamps", source=_TACLINK, ge=10, le=1000
    )
    base_radius: float = parameter(
        32.804, unit="mm", meaning="radius of the inner surface at both ends", source=_TACLINK, ge=5, le=200
    )
    middle_radius: float = parameter(
        50.0, unit="mm", meaning="radius of the inner surface halfway", source=_TACLINK, ge=5, le=300
    )
    thickness: float = parameter(
        3.361,
        unit="mm",
        meaning="skin thickness, outward from the inner surface",
        source=_TACLINK,
        ge=0.2,
        le=30,
    )

    def build(self) -> Barrel:
        bulge = self.middle_radius - self.base_radius
        if not _LEAST_BULGE * self.height < bulge <= 0.5 * self.height:
            raise PalpateError(
                f"A barrel of length {self.height:g} mm with a radius of {self.base_radius:g} mm at its ends and "
                f"{self.middle_radius:g} mm halfway does not bulge, or by more than half its length.",
                f"Use a radius halfway of more than {self.base_radius:g} mm, up to "
                f"{self.base_radius + 0.5 * self.height:g} mm.",
                code="barrel-not-bulging",
            )
        return Barrel(self.height, self.base_radius, self.thickness, self.middle_radius)


@final
@dataclass(frozen=True)
class Barrel(Skin):
    """Geometry of a barrel: with h = H/2 and bulge b, an arc of radius ``R = (h² + b²)/2b`` about (-a, h).

    The angle φ along the arc increases from the far end (negative) over the middle (0) to the rim. A layer at the
    distance ``ρ = R + λ T`` from the centre is ``(ρ cos φ - a, h - ρ sin φ)``. For the dimensions see `BarrelSpec`.
    """

    height: float
    base_radius: float
    thickness: float
    middle_radius: float

    hole: ClassVar[float] = HOLE

    @property
    def name(self) -> str:
        return f"barrel {self.middle_radius:g} {super().name}"

    @property
    def shape(self) -> str:
        return "barrel"

    @property
    def spec_data(self) -> dict[str, Any]:
        return {"kind": "barrel", **asdict(self)}

    @property
    def symmetry(self) -> Symmetry:
        return Symmetry.REVOLVED

    @property
    def radius(self) -> float:
        """See `Skin`: halfway, around the axis, its smaller radius of curvature."""
        return self.middle_radius

    @property
    def widest(self) -> tuple[float, float]:
        return self.middle_radius, self.height / 2

    @property
    def outer_height(self) -> float:
        """See `Skin`: height of the far end."""
        return self.height

    @cached_property
    def arc_radius(self) -> float:
        """Radius R of the inner surface's arc, mm."""
        half, bulge = self.height / 2, self.middle_radius - self.base_radius
        return (half**2 + bulge**2) / (2 * bulge)

    @property
    def centre_radius(self) -> float:
        """Distance a of the arc's centre beyond the axis, mm."""
        return self.arc_radius - self.middle_radius

    def end_angle(self, layer: float, rim: Rim = Rim.FLAT) -> float:
        """Return the angle φ (rad) at which a layer ends at the rim; at the far end it is the negative."""
        reach = self.arc_radius + (layer * self.thickness if rim is Rim.FLAT else 0.0)
        return float(np.arcsin(self.height / 2 / reach))

    def scaled(self, factor: float) -> Self:
        return type(self)(*(factor * size for size in asdict(self).values()))

    def _place(self, angle: FloatArray, layer: float) -> FloatArray:
        """Return distance from the axis and height (n, 2) mm at angles φ (n,) of a layer."""
        reach = self.arc_radius + layer * self.thickness
        bulge = self.middle_radius - self.arc_radius * 2 * np.sin(angle / 2) ** 2  # R cos φ - a without cancellation
        across = bulge + layer * self.thickness * np.cos(angle)
        return np.column_stack([across, self.height / 2 - reach * np.sin(angle)])

    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        s = np.hypot(disc[:, 0], disc[:, 1])
        share = (s - HOLE) / (1 - HOLE)
        place = self._place((2 * share - 1) * self.end_angle(layer, rim), layer)
        direction = np.divide(disc, s[:, None], out=np.zeros_like(disc), where=s[:, None] > 0)
        return np.column_stack([place[:, :1] * direction, place[:, 1]])

    def _foot(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return angle φ (n,), distance (n,) mm from the arc, and direction (n, 2) of points (n, 3) mm."""
        across = np.hypot(points[:, 0], points[:, 1])
        direction = np.where(across[:, None] > 0, points[:, :2] / np.maximum(across, 1e-300)[:, None], [1.0, 0.0])
        arm, drop = across + self.centre_radius, self.height / 2 - points[:, 2]
        return np.arctan2(drop, arm), np.hypot(arm, drop) - self.arc_radius, direction

    def disc(self, points: FloatArray) -> FloatArray:
        angle, _, direction = self._foot(points)
        share = (angle / self.end_angle(0.0) + 1) / 2
        return np.asarray((HOLE + (1 - HOLE) * share)[:, None] * direction)

    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        """See `Skin`: in the half beyond the middle; NaN inside the opening of the far end."""
        rho, azimuth = np.broadcast_arrays(np.asarray(rho, float), np.asarray(azimuth, float))
        inside = (rho <= self.middle_radius * (1 + 1e-12)) & (rho >= self.base_radius * (1 - 1e-12))
        rise = np.maximum(self.arc_radius**2 - (rho + self.centre_radius) ** 2, 0.0)
        height = np.where(inside, self.height / 2 + np.sqrt(rise), np.nan)
        return np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth), height], axis=-1)

    def normal(self, points: FloatArray) -> FloatArray:
        points = np.asarray(points, float)
        angle, _, direction = self._foot(points.reshape(-1, 3))
        return _across(angle, direction).reshape(points.shape)

    def nearest(self, points: FloatArray) -> FloatArray:
        points = np.asarray(points, float)
        angle, _, direction = self._foot(points.reshape(-1, 3))
        place = self._place(angle, 0.0)
        return np.column_stack([place[:, :1] * direction, place[:, 1]]).reshape(points.shape)

    def distance(self, points: ArrayLike) -> FloatArray:
        points = np.asarray(points, float)
        return self._foot(points.reshape(-1, 3))[1].reshape(points.shape[:-1])

    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        points = np.asarray(points, float)
        angle = self._foot(points.reshape(-1, 3))[0]
        return np.asarray(self.arc_radius * (self.end_angle(0.0) - angle).reshape(points.shape[:-1]))

    def arc_length(self, points: FloatArray) -> FloatArray:
        """See `Skin`: from the far end."""
        return np.asarray(self.arc_radius * (self._foot(points)[0] + self.end_angle(0.0)))

    def at_arc_length(self, length: FloatArray) -> FloatArray:
        return self._place(np.asarray(length) / self.arc_radius - self.end_angle(0.0), 0.0)[:, 0]

    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        """See `Skin`: a ray that leaves through the opening of the far end misses."""
        points = trace_rays(self._gap, lambda at: np.hypot(at[:, 0], at[:, 1]) <= self.base_radius, origin, rays)
        points[~(points[:, 2] <= self.height)] = np.nan
        return points

    def _gap(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        angle, far, direction = self._foot(points)
        return far, _across(angle, direction)

    def support_point(self, normal: FloatArray) -> FloatArray:
        across, end = float(np.hypot(normal[0], normal[1])), self.end_angle(1.0)
        angle = float(np.clip(np.arctan2(-normal[2], across), -end, end))
        place = self._place(np.array([angle]), 1.0)[0]
        direction = np.array([normal[0], normal[1]]) / across if across > 0 else np.array([1.0, 0.0])
        return np.array([*(place[0] * direction), place[1]])

    @property
    def inner_slope(self) -> float:
        return float(np.pi / 2 + self.end_angle(0.0))

    def rim_slope(self, rim: Rim) -> float:
        """See `Skin`; at the far end it is π minus this."""
        return float(np.pi / 2 + self.end_angle(1.0, rim))

    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        """See `Skin`: for a wall that moves along its own normal, at the nearer end."""
        normal, end = np.array([np.sin(tilt), np.cos(tilt)]), self.end_angle(1.0, rim)
        edges = self._place(np.array([-end, end]), 1.0) @ normal
        touch = self.support_point(np.array([normal[0], 0.0, normal[1]]))
        return float(touch[[0, 2]] @ normal - edges.max())

    def meridian(self, offset: float, *, down: bool) -> Outline:
        """See `Skin`: from the far end to the base, or back; both ends are equally wide."""
        layer = offset / self.thickness
        end = self._place(np.array([self.end_angle(layer)]), layer)[0, 0]
        middle = (self.middle_radius + offset, self.height / 2)
        return [Arc(middle, (float(end), 0.0 if down else self.height))]


def _across(angle: FloatArray, direction: FloatArray) -> FloatArray:
    """Return outward unit normals (n, 3) at angles φ (n,) and directions (n, 2)."""
    return np.column_stack([np.cos(angle)[:, None] * direction, -np.sin(angle)])
