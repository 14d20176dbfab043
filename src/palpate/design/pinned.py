"""Dome whose markers are the tips of pins on its inner surface, like a TacTip.

        .-''''''-.        skin: a dome's
      .' | | | |  '.
     / \\ ' ' ' '  / \\     pins along the inner normals; their tips lie on a sphere about the same centre
    |   '         '   |
    |_|             |_|

Rotation of the skin additionally moves a tip by the length of its pin times the angle: pins magnify small tilts. They
are rigid and carry no load.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal, Self, final

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray, PalpateError, parameter
from palpate.design.dome import Dome
from palpate.design.outline import Outline
from palpate.design.skin import Rim, Skin, Symmetry
from palpate.design.spec import SkinSpec

_LONGEST = 0.8
"""Maximum length of a pin over the height of the dome: tips stay above the base. By hand."""


@final
class PinnedSpec(SkinSpec):
    """Dome with pins inside, whose tips are the markers."""

    kind: Literal["pinned"] = "pinned"
    pin: float = parameter(2.0, unit="mm", meaning="length of a pin, inward from the skin", gt=0, le=20)

    def build(self) -> PinnedDome:
        if self.height > self.base_radius:
            raise PalpateError(
                f"A dome with a height of {self.height:g} mm on a base radius of {self.base_radius:g} mm bulges: a "
                "core with pins cannot be removed.",
                f"Use a height up to {self.base_radius:g} mm.",
                code="dome-bulges",
            )
        if self.pin > _LONGEST * self.height:
            raise PalpateError(
                f"Pins {self.pin:g} mm long in a dome {self.height:g} mm high meet in its middle or reach its base.",
                f"Use at most {_LONGEST * self.height:.3g} mm.",
                code="pins-too-long",
            )
        return PinnedDome(self.height, self.base_radius, self.thickness, self.pin)


@final
@dataclass(frozen=True)
class PinnedDome(Skin):
    """Geometry of a dome with pins: a dome, whose marked surface is the sphere of the tips."""

    height: float
    base_radius: float
    thickness: float
    pin: float

    @cached_property
    def wall(self) -> Dome:
        """The dome without its pins."""
        return Dome(self.height, self.base_radius, self.thickness)

    @property
    def tip_radius(self) -> float:
        """Radius of the sphere of the tips, mm."""
        return self.wall.radius - self.pin

    @property
    def name(self) -> str:
        return f"{super().name} pins {self.pin:g}"

    @property
    def shape(self) -> str:
        return f"{self.wall.shape} with pins"

    @property
    def spec_data(self) -> dict[str, Any]:
        return {"kind": "pinned", **asdict(self)}

    @property
    def symmetry(self) -> Symmetry:
        return Symmetry.REVOLVED

    @property
    def radius(self) -> float:
        return self.wall.radius

    @property
    def widest(self) -> tuple[float, float]:
        polar = self.wall.rim_polar_angle
        return self.tip_radius * float(np.sin(polar)), self.wall.center_z + self.tip_radius * float(np.cos(polar))

    @property
    def outer_widest(self) -> tuple[float, float]:
        return self.wall.outer_widest

    def scaled(self, factor: float) -> Self:
        return type(self)(*(factor * size for size in (self.height, self.base_radius, self.thickness, self.pin)))

    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        return self.wall.point(disc, layer, rim)

    def marked(self, disc: FloatArray) -> FloatArray:
        roots = self.wall.point(disc, 0.0)
        return roots - self.pin * self.wall.normal(roots)

    def disc(self, points: FloatArray) -> FloatArray:
        return self.wall.disc(points)

    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        rho, azimuth = np.broadcast_arrays(np.asarray(rho, float), np.asarray(azimuth, float))
        inside = rho <= self.widest[0] * (1.0 + 1e-12)
        drop = np.sqrt(np.where(inside, np.maximum(self.tip_radius**2 - rho**2, 0.0), np.nan))
        return np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth), self.wall.center_z + drop], axis=-1)

    def normal(self, points: FloatArray) -> FloatArray:
        return self.wall.normal(points)

    def nearest(self, points: FloatArray) -> FloatArray:
        return self.wall.centre + self.tip_radius * self.normal(points)

    def distance(self, points: ArrayLike) -> FloatArray:
        return np.asarray(self.wall.distance(points) + self.pin)

    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        """See `Skin`: along the sphere of the tips to the tip of a pin at the rim."""
        return np.asarray(self.wall.distance_to_rim(points) * (self.tip_radius / self.radius))

    def arc_length(self, points: FloatArray) -> FloatArray:
        return np.asarray(self.wall.arc_length(points) * (self.tip_radius / self.radius))

    def at_arc_length(self, length: FloatArray) -> FloatArray:
        return np.asarray(self.tip_radius * np.sin(length / self.tip_radius))

    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        # the dome whose inner surface is the sphere of the tips
        z = self.wall.center_z
        return Dome(z + self.tip_radius, float(np.sqrt(max(self.tip_radius**2 - z**2, 0.0))), 1.0).hit(origin, rays)

    def support_point(self, normal: FloatArray) -> FloatArray:
        return self.wall.support_point(normal)

    @property
    def inner_slope(self) -> float:
        return self.wall.inner_slope

    def rim_slope(self, rim: Rim) -> float:
        return self.wall.rim_slope(rim)

    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        return self.wall.clamp_depth(tilt, rim)

    def meridian(self, offset: float, *, down: bool) -> Outline:
        return self.wall.meridian(offset, down=down)
