"""Skin as the cap of an ellipsoid of revolution, flatter or steeper at the apex than a dome."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal, Self, final

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray, parameter
from palpate.design.ray import leave_sphere, pass_base
from palpate.design.revolved import RevolvedSkin, plain_numbers
from palpate.design.spec import TaperedSpec


@final
class EllipsoidSpec(TaperedSpec):
    """Cap of an ellipsoid of revolution, measured on its inner surface."""

    kind: Literal["ellipsoid"] = "ellipsoid"
    aspect: float = parameter(
        1.0, unit="1", meaning="semi-axis along the axis over that across; 1: a dome", ge=0.2, le=5
    )

    def build(self) -> Ellipsoid:
        return Ellipsoid(self.height, self.base_radius, self.thickness, self.aspect, self.taper)


@final
@dataclass(frozen=True)
class Ellipsoid(RevolvedSkin):
    """Cap of an ellipsoid with the semi-axes a across and k a along its axis, cut at z = 0.

    From ``z0 + k a = H`` and ``B²/a² + z0²/(k a)² = 1``: ``z0 = (H² - k² B²) / (2 H)``, ``a = (H - z0) / k``; k = 1
    gives the sphere of `Dome`. k is `aspect`, below 1 flatter at the apex than a sphere; for the further dimensions
    see `RevolvedSkin`.
    """

    height: float
    base_radius: float
    thickness: float
    aspect: float
    taper: float = 1.0

    @property
    def name(self) -> str:
        return f"ellipsoid {self.aspect:g} {super().name}"

    @property
    def shape(self) -> str:
        return f"ellipsoid of aspect {self.aspect:g}"

    @property
    def spec_data(self) -> dict[str, Any]:
        return plain_numbers("ellipsoid", asdict(self))

    @property
    def centre_height(self) -> float:
        """Height z0 of the ellipsoid's centre over the base, mm."""
        return (self.height**2 - (self.aspect * self.base_radius) ** 2) / (2.0 * self.height)

    @property
    def semi_axis(self) -> float:
        """Semi-axis a across the axis, mm."""
        return (self.height - self.centre_height) / self.aspect

    @property
    def radius(self) -> float:
        return self.semi_axis / self.aspect

    def scaled(self, factor: float) -> Self:
        sizes = (factor * self.height, factor * self.base_radius, factor * self.thickness)
        return type(self)(*sizes, self.aspect, self.taper)

    def curve(self, t: FloatArray, order: int = 0) -> FloatArray:
        a, end = self.semi_axis, np.arctan2(self.aspect * self.base_radius, -self.centre_height)
        phase = end * t + order * np.pi / 2
        curve = a * end**order * np.column_stack([np.sin(phase), self.aspect * np.cos(phase)])
        return curve + np.array([0.0, self.centre_height if order == 0 else 0.0])

    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        """See `Skin`: ``z = z0 + k √(a² - ρ²)``."""
        rho, azimuth = np.broadcast_arrays(np.asarray(rho, float), np.asarray(azimuth, float))
        inside = rho <= self.widest[0] * (1.0 + 1e-9)
        rise = self.aspect * np.sqrt(np.where(inside, np.maximum(self.semi_axis**2 - rho**2, 0.0), np.nan))
        return np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth), self.centre_height + rise], axis=-1)

    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        """See `Skin`: the second intersection with a sphere of radius a, after division by k along the axis."""
        start = pass_base(lambda at: np.hypot(at[:, 0], at[:, 1]) <= self.base_radius, origin, rays)
        round_, middle = np.array([1.0, 1.0, 1.0 / self.aspect]), np.array([0.0, 0.0, self.centre_height])
        far = leave_sphere((start - middle) * round_, rays * round_, self.semi_axis)
        return np.asarray(start + far[:, None] * rays)
