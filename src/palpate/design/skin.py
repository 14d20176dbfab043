"""Skin: the elastomer body over a flat base that is pressed, with markers on its inner surface.

All stages use a skin through this interface only. The origin is the centre of the base plane z = 0, z points along
the axis to the apex; lengths in mm. The *unit disc* maps both surfaces: its centre is the apex, its edge the
rim.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from enum import StrEnum
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray, PalpateError
from palpate.design.outline import Outline
from palpate.design.solid import CadSolid, loft, revolve
from palpate.design.superellipse import Superellipse

PAPER_BASE = 20.0
"""Base radius of the paper's domes in mm; names omit it."""
SIZE_MM = 20.0
"""Radius of the skin on which constants with a length were measured, mm: H20 T2."""
_AT_APEX = 1e-9
"""Sine of the slope below which a point counts as the apex."""


class Rim(StrEnum):
    """Shape of a skin's rim: cut flat at z = 0 as molded, or along the normals of the inner surface."""

    FLAT = "flat"
    RADIAL = "radial"


class Symmetry(StrEnum):
    """Symmetry under rotation about the axis, which determines the interpolation of presses."""

    REVOLVED = "revolved"
    """Any rotation: one press serves every azimuth."""
    MIRRORED = "mirrored"
    """Mirrors x → -x and y → -y only, hence the half turn: azimuths up to 90° serve all."""
    NONE = "none"
    """No symmetry: every azimuth needs its own press."""


_LEVEL = 5e-4
"""Excess width over the base radius that is not counted as a bulge: 0.01 mm of 20 mm.

It is below the accuracy of a mold. A meridian that follows a drawn hemisphere is wider by 0.3 µm."""


class Skin(ABC):
    """Geometry of one skin.

    Attributes
    ----------
    height, base_radius, thickness
        Height of the inner surface's apex over the base, radius of its rim, skin thickness at the apex, mm.
    pin
        Length of the pins whose tips are the markers, mm; 0 if they are printed on the inner surface itself.
    hole
        Radius on the unit disc of the circle at which a skin ends that is open at its far end too, as a barrel; 0 if
        it has an apex.
    """

    height: float
    base_radius: float
    thickness: float
    pin: float = 0.0
    hole: ClassVar[float] = 0.0

    @property
    def name(self) -> str:
        """Short name with the parameters that distinguish it from other skins of its shape, e.g. ``H20 T2``."""
        base = "" if self.base_radius == PAPER_BASE else f" B{self.base_radius:g}"
        return f"H{self.height:g}{base} T{self.thickness:g}"

    @property
    @abstractmethod
    def shape(self) -> str:
        """Name of the shape, without sizes, such as ``hemisphere``."""

    @property
    @abstractmethod
    def spec_data(self) -> dict[str, Any]:
        """Plain values from which `palpate.design.skin_from_data` builds this skin's spec again."""

    @property
    @abstractmethod
    def symmetry(self) -> Symmetry:
        """Symmetry under rotation about the axis."""

    @property
    @abstractmethod
    def radius(self) -> float:
        """Radius of curvature of the inner surface at the apex, mm; if that is flat, the minimum next to it."""

    @property
    @abstractmethod
    def widest(self) -> tuple[float, float]:
        """Maximum distance of the inner surface from the axis and its height over the base, mm."""

    @property
    def size(self) -> float:
        """Maximum radius over `SIZE_MM`; constants measured on a skin of size 1 scale with it."""
        return self.widest[0] / SIZE_MM

    @property
    def plan(self) -> Superellipse:
        """Common plan of the surfaces, half width 1 along x; the section along x is swept around it."""
        return Superellipse(1.0, 2.0)

    @property
    def rim_thickness(self) -> float:
        """Skin thickness at the rim, along the normal, mm; by default that at the apex."""
        return self.thickness

    def reach(self, azimuth: ArrayLike) -> FloatArray:
        """Return the maximum distance (...) mm of the inner surface from the axis at azimuths (...) in rad."""
        return np.full(np.shape(azimuth), self.widest[0])

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """Return the skin with every length multiplied."""

    @abstractmethod
    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        """Return points (n, 3) mm at places (n, 2) of the unit disc; layer 0 is the inner surface, 1 outer."""

    def marked(self, disc: FloatArray) -> FloatArray:
        """Return points (n, 3) mm of the marked surface (inner surface, or pin tips) at places of the disc.

        The methods below refer to the marked surface as the inner one.
        """
        return self.point(disc, 0.0)

    @abstractmethod
    def disc(self, points: FloatArray) -> FloatArray:
        """Return places (n, 2) on the unit disc of points near the marked surface; beyond 1 below the rim."""

    @abstractmethod
    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        """Project points of the base plane along the axis onto the inner surface; the upper one if it bulges.

        Their distance from the axis is `rho` (...), mm, their angle about the axis from x `azimuth` (...), rad; the
        result is (..., 3) mm, with z NaN beyond the skin's widest circle.
        """

    def tangents(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return normals, unit vectors along the meridian from the apex, and along the circle, (n, 3) each.

        At the apex, which has no meridian, they point along x and y.
        """
        normals = self.normal(points)
        circle = np.cross([0.0, 0.0, 1.0], normals)
        length = np.linalg.norm(circle, axis=1, keepdims=True)
        circle = np.where(length < _AT_APEX, [[0.0, 1.0, 0.0]], circle / np.maximum(length, _AT_APEX))
        return normals, np.cross(circle, normals), circle

    @abstractmethod
    def normal(self, points: FloatArray) -> FloatArray:
        """Return the outward unit normal (..., 3) of the inner surface at points (..., 3) mm on or near it."""

    @abstractmethod
    def nearest(self, points: FloatArray) -> FloatArray:
        """Return the points (..., 3) mm of the inner surface nearest to points (..., 3) mm."""

    @abstractmethod
    def distance(self, points: ArrayLike) -> FloatArray:
        """Return the signed distance (...) mm of points (..., 3) mm from the inner surface, positive outward."""

    @abstractmethod
    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        """Return the distance (...) mm along the meridian from points (..., 3) mm to the rim."""

    @abstractmethod
    def arc_length(self, points: FloatArray) -> FloatArray:
        """Return the distance (n,) mm along the meridian from the apex to points (n, 3) mm."""

    @abstractmethod
    def at_arc_length(self, length: FloatArray) -> FloatArray:
        """Return the distance (n,) mm from the axis at lengths (n,) mm along the meridian from the apex."""

    @abstractmethod
    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        """Return the points (n, 3) mm where rays (n, 3) leave the inner surface; NaN if they miss.

        They come from one origin (3,) mm, or each from its own (n, 3).
        """

    @abstractmethod
    def support_point(self, normal: FloatArray) -> FloatArray:
        """Return the point (3,) mm of first contact with a wall of this outward normal (3,)."""

    def support_height(self, normals: FloatArray) -> FloatArray:
        """Return heights (n,) mm on the axis of walls of these outward normals (n, 3) at first contact."""
        return np.array([self.support_point(normal) @ normal / normal[2] for normal in normals])

    @property
    @abstractmethod
    def inner_slope(self) -> float:
        """Angle in rad between the axis and the inner surface's normal at its rim; above π/2 if it bulges."""

    @abstractmethod
    def rim_slope(self, rim: Rim) -> float:
        """Return the angle in rad between axis and outer normal at the rim: that tilt touches the clamp."""

    @abstractmethod
    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        """Return the depth in mm at which a wall of this tilt (rad) reaches the clamped outer rim."""

    @abstractmethod
    def meridian(self, offset: float, *, down: bool) -> Outline:
        """Return the half section (x, z) mm of the surface `offset` mm outside the inner one, along x.

        It runs from apex to base (`down`) or back, without its first point, because it continues an outline. For a
        tapered skin, a positive offset is that at the apex, and proportional to the thickness elsewhere.
        """

    def solid(self, outline: Outline) -> CadSolid:
        """Sweep an outline of (x, z) mm, the half section along x, around the plan."""
        return revolve(outline) if self.plan.is_round else loft(outline, self.plan.edge)

    @property
    def bulges(self) -> bool:
        """Whether the inner surface is wider than at its rim, so that a rigid core cannot be pulled out."""
        return self.widest[0] > self.base_radius * (1 + _LEVEL)

    @property
    def outer_widest(self) -> tuple[float, float]:
        """Maximum distance of the outer surface from the axis and its height over the base, mm."""
        radius, height = self.widest
        return (radius + self.thickness, height) if self.bulges else (self.outer_base_radius, 0.0)

    @property
    def outer_base_radius(self) -> float:
        """Radius of the outer surface's rim in the base plane, mm."""
        return float(np.hypot(*self.point(np.array([[1.0, 0.0]]), 1.0)[0, :2]))

    @property
    def outer_height(self) -> float:
        """Height of the outer surface's apex over the base, mm."""
        return self.height + self.thickness

    def require_revolution(self, why: str, remedy: str, *, code: str = "skin-not-revolution") -> None:
        """Raise an error unless the skin is a body of revolution with an apex.

        Raises
        ------
        PalpateError
            With the reason `why`, a part of a sentence, the remedy, and the code of the request.
        """
        if self.symmetry is not Symmetry.REVOLVED:
            raise PalpateError(f"{self.name} is not a body of revolution: {why}.", remedy, code=code)
        if self.hole:
            raise PalpateError(
                f"{self.name} has no apex, and this function does not support barrels.",
                remedy,
                code="skin-no-apex",
            )
