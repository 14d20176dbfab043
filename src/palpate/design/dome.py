"""Dome: a hollow spherical cap on a flat base.

        .-''''''-.        outer surface, radius r + T
      .'  .----.  '.
     /  .'      '.  \\     inner surface, radius r; it carries the markers
    |  /    |     \\  |
    |_|     |H     |_|    base plane z = 0, clamped annulus
       <-B->

The origin is the centre of the base plane, z points along the axis to the apex; lengths in mm.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, Self, final

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray
from palpate.design.outline import Arc, Outline
from palpate.design.ray import leave_sphere
from palpate.design.skin import Rim, Skin, Symmetry
from palpate.design.spec import SkinSpec


class DomeShape(StrEnum):
    """Name of a dome's shape, as in the paper: height below, at or above the base radius."""

    SEGMENT = "hemispherical segment"
    HEMISPHERE = "hemisphere"
    CAP = "spherical cap"


@final
class DomeSpec(SkinSpec):
    """Dome: spherical cap of constant thickness, with dimensions of its inner surface."""

    def build(self) -> Dome:
        return Dome(height=self.height, base_radius=self.base_radius, thickness=self.thickness)


@final
@dataclass(frozen=True)
class Dome(Skin):
    """Geometry of a dome.

    Attributes
    ----------
    height, base_radius, thickness
        H and B of the inner surface, and the skin thickness T outward from it, mm.
    """

    height: float
    base_radius: float
    thickness: float

    @property
    def radius(self) -> float:
        """Radius of the inner sphere, mm: r = (H² + B²) / (2 H), Eq. 1 of the paper."""
        return (self.height**2 + self.base_radius**2) / (2.0 * self.height)

    @property
    def outer_radius(self) -> float:
        """Radius of the outer sphere, mm: r + T, about the same centre."""
        return self.radius + self.thickness

    @property
    def center_z(self) -> float:
        """Height of the spheres' centre over the base plane, mm: H - r."""
        return self.height - self.radius

    @property
    def shape(self) -> DomeShape:
        if self.height < self.base_radius:
            return DomeShape.SEGMENT
        return DomeShape.HEMISPHERE if self.height == self.base_radius else DomeShape.CAP

    @property
    def rim_polar_angle(self) -> float:
        """Polar angle of the inner rim about the spheres' centre, rad; above π/2 for a spherical cap."""
        return float(np.arctan2(self.base_radius, -self.center_z))

    @property
    def spec_data(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def symmetry(self) -> Symmetry:
        return Symmetry.REVOLVED

    @property
    def widest(self) -> tuple[float, float]:
        if self.height > self.base_radius:
            return self.radius, self.center_z
        return self.base_radius, 0.0

    @property
    def outer_base_radius(self) -> float:
        """Radius of the outer surface's rim in the base plane, mm."""
        return float(np.sqrt(self.outer_radius**2 - self.center_z**2))

    @property
    def centre(self) -> FloatArray:
        """Common centre (3,) of the spheres, mm."""
        return np.array([0.0, 0.0, self.center_z])

    def scaled(self, factor: float) -> Self:
        return type(self)(factor * self.height, factor * self.base_radius, factor * self.thickness)

    def rim_angle(self, radius: float, rim: Rim) -> float:
        """Return the polar angle in rad at which the sphere of this radius (mm) ends at the base."""
        on = radius if rim is Rim.FLAT else self.radius
        return float(np.arccos(np.clip((self.radius - self.height) / on, -1.0, 1.0)))

    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        radius = self.radius + layer * self.thickness
        s = np.hypot(disc[:, 0], disc[:, 1])
        polar = s * self.rim_angle(radius, rim)
        direction = np.divide(disc, s[:, None], out=np.zeros_like(disc), where=s[:, None] > 0)
        across = radius * np.sin(polar)[:, None] * direction
        return np.column_stack([across, self.center_z + radius * np.cos(polar)])

    def disc(self, points: FloatArray) -> FloatArray:
        arm = points - [0.0, 0.0, self.center_z]
        rho = np.hypot(arm[:, 0], arm[:, 1])
        s = np.arctan2(rho, arm[:, 2]) / self.rim_angle(self.radius, Rim.FLAT)
        direction = np.divide(arm[:, :2], rho[:, None], out=np.zeros((len(points), 2)), where=rho[:, None] > 0)
        return np.asarray(s[:, None] * direction)

    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        """See `Skin`: ``z = (H - r) + √(r² - ρ²)``."""
        rho, azimuth = np.broadcast_arrays(np.asarray(rho, float), np.asarray(azimuth, float))
        inside = rho <= self.widest[0] * (1.0 + 1e-12)
        drop = np.sqrt(np.where(inside, np.maximum(self.radius**2 - rho**2, 0.0), np.nan))
        return np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth), self.center_z + drop], axis=-1)

    def normal(self, points: FloatArray) -> FloatArray:
        arm = np.asarray(points, float) - self.centre
        return np.asarray(arm / np.linalg.norm(arm, axis=-1, keepdims=True))

    def nearest(self, points: FloatArray) -> FloatArray:
        return self.centre + self.radius * self.normal(points)

    def distance(self, points: ArrayLike) -> FloatArray:
        arm = np.asarray(points, float) - self.centre
        return np.asarray(np.linalg.norm(arm, axis=-1) - self.radius)

    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        points = np.asarray(points, float)
        polar = np.arctan2(np.hypot(points[..., 0], points[..., 1]), points[..., 2] - self.center_z)
        return np.asarray(self.radius * (self.rim_polar_angle - polar))

    def arc_length(self, points: FloatArray) -> FloatArray:
        rho = np.hypot(points[:, 0], points[:, 1])
        return np.asarray(self.radius * np.arctan2(rho, points[:, 2] - self.center_z))

    def at_arc_length(self, length: FloatArray) -> FloatArray:
        return np.asarray(self.radius * np.sin(length / self.radius))

    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        """See `Skin`: the second intersection with ``|o + s d - c| = r``."""
        return np.asarray(origin + leave_sphere(origin - self.centre, rays, self.radius)[:, None] * rays)

    def support_point(self, normal: FloatArray) -> FloatArray:
        return self.centre + self.outer_radius * normal

    @property
    def inner_slope(self) -> float:
        return self.rim_angle(self.radius, Rim.FLAT)

    def rim_slope(self, rim: Rim) -> float:
        return self.rim_angle(self.outer_radius, rim)

    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        """See `Skin`: ``d = R (1 - cos(theta_rim - t)) / cos t`` with the outer rim's polar angle theta_rim."""
        theta = self.rim_angle(self.outer_radius, rim)
        return float(self.outer_radius * (1.0 - np.cos(theta - tilt)) / np.cos(tilt))

    def meridian(self, offset: float, *, down: bool) -> Outline:
        radius = self.radius + offset
        angle = float(np.arccos(-self.center_z / radius))
        half = float(radius * np.sin(angle / 2)), float(self.center_z + radius * np.cos(angle / 2))
        end = (float(radius * np.sin(angle)), 0.0) if down else (0.0, self.center_z + radius)
        return [Arc(half, end)]
