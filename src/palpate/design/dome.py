"""The dome: a sector of a hollow sphere on a flat base.

        .-''''''-.        outer surface, radius r + T
      .'  .----.  '.
     /  .'      '.  \\     inner surface, radius r; it carries the markers
    |  /    |     \\  |
    |_|     |H     |_|    base plane z = 0, clamped annulus
       <-B->

The frame's origin is the middle of the base plane, z runs along the axis to the apex; lengths in mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray


class DomeShape(StrEnum):
    """Name of a dome's shape, as in the paper: height below, at or above the base radius."""

    SEGMENT = "hemispherical segment"
    HEMISPHERE = "hemisphere"
    CAP = "spherical cap"


@dataclass(frozen=True)
class Dome:
    """Geometry of one dome.

    Attributes
    ----------
    height, base_radius, thickness
        H and B of the inner surface, and the wall's thickness T outward from it, mm.
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
        """The shape's name in the paper."""
        if self.height < self.base_radius:
            return DomeShape.SEGMENT
        return DomeShape.HEMISPHERE if self.height == self.base_radius else DomeShape.CAP

    @property
    def rim_polar_angle(self) -> float:
        """Polar angle of the inner rim about the spheres' centre, rad; above π/2 for a spherical cap."""
        return float(np.arctan2(self.base_radius, -self.center_z))

    @property
    def widest_radius(self) -> float:
        """Greatest distance of the inner surface from the axis, mm: B, or r where the dome bulges."""
        return self.radius if self.height > self.base_radius else self.base_radius

    @property
    def outer_base_radius(self) -> float:
        """Radius of the outer surface's rim in the base plane, mm."""
        return float(np.sqrt(self.outer_radius**2 - self.center_z**2))

    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        """Points of the base plane carried along the axis to the inner surface.

        z = (H - r) + √(r² - ρ²): the upper of the two crossings, where a dome bulges over its base.

        Parameters
        ----------
        rho
            (...) distance from the axis, mm.
        azimuth
            (...) angle about the axis from x, rad.

        Returns
        -------
        ndarray
            (..., 3) points, mm; z is NaN where `rho` is beyond the dome's widest radius.
        """
        rho, azimuth = np.broadcast_arrays(np.asarray(rho, float), np.asarray(azimuth, float))
        inside = rho <= self.widest_radius * (1.0 + 1e-12)
        drop = np.sqrt(np.where(inside, np.maximum(self.radius**2 - rho**2, 0.0), np.nan))
        return np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth), self.center_z + drop], axis=-1)

    def distance_to_inner(self, points: ArrayLike) -> FloatArray:
        """Signed distance of points from the inner sphere, positive outward.

        Parameters
        ----------
        points
            (..., 3) mm.

        Returns
        -------
        ndarray
            (...) mm.
        """
        arm = np.asarray(points, float) - np.array([0.0, 0.0, self.center_z])
        distance: FloatArray = np.linalg.norm(arm, axis=-1) - self.radius
        return distance

    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        """Distance along the meridian from points of the inner surface to the rim; negative below it.

        Parameters
        ----------
        points
            (..., 3) mm.

        Returns
        -------
        ndarray
            (...) mm.
        """
        points = np.asarray(points, float)
        polar = np.arctan2(np.hypot(points[..., 0], points[..., 1]), points[..., 2] - self.center_z)
        return np.asarray(self.radius * (self.rim_polar_angle - polar))
