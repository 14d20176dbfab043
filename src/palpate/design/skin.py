"""A skin: the soft wall over a flat base that an obstacle presses and whose inner surface carries the markers.

Every stage asks a skin the questions below and knows no more of its shape. The frame's origin is the middle of the
base plane z = 0, z runs along the axis to the apex; lengths in mm. The *unit disc* is the map of both surfaces: its
middle is the apex, its edge the rim.
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
"""Base radius of the paper's domes in mm; a name does not repeat it."""
_AT_APEX = 1e-9
"""Sine of the slope below which a point counts as the apex."""


class Rim(StrEnum):
    """How a skin ends at its base: cut flat at z = 0 as molded, or along the normals of the inner surface."""

    FLAT = "flat"
    RADIAL = "radial"


class Symmetry(StrEnum):
    """What a turn about the axis leaves as it is; it decides how presses are interpolated."""

    REVOLVED = "revolved"
    """Any turn: one press serves every azimuth."""
    MIRRORED = "mirrored"
    """None but the half turn, for the mirrors x → -x and y → -y leave it as it is: azimuths up to 90° serve all."""
    NONE = "none"
    """No turn: every azimuth is pressed for itself."""


class Skin(ABC):
    """Geometry of one skin.

    Attributes
    ----------
    height, base_radius, thickness
        Of the inner surface's apex over the base, of its rim, and of the wall outward from it at the apex, mm.
    pin
        Length of the pins whose tips are the markers, mm; 0: they are printed on the inner surface itself.
    hole
        Radius on the unit disc of the circle at which a skin ends that is open at its far end too, as a barrel; 0: it
        is closed by an apex.
    """

    height: float
    base_radius: float
    thickness: float
    pin: float = 0.0
    hole: ClassVar[float] = 0.0

    @property
    def name(self) -> str:
        """Short name with the numbers that tell one skin from another of its shape, e.g. ``H20 T2``."""
        base = "" if self.base_radius == PAPER_BASE else f" B{self.base_radius:g}"
        return f"H{self.height:g}{base} T{self.thickness:g}"

    @property
    @abstractmethod
    def shape(self) -> str:
        """The shape in words, without its sizes: ``hemisphere``."""

    @property
    @abstractmethod
    def spec_data(self) -> dict[str, Any]:
        """Plain values from which `palpate.design.skin_from_data` reads this skin's spec again."""

    @property
    @abstractmethod
    def symmetry(self) -> Symmetry:
        """What a turn about the axis leaves as it is."""

    @property
    @abstractmethod
    def radius(self) -> float:
        """Radius of curvature of the inner surface at the apex, mm; where that is flat, the least one beside it."""

    @property
    @abstractmethod
    def widest(self) -> tuple[float, float]:
        """Greatest distance of the inner surface from the axis and its height over the base, mm."""

    @property
    def plan(self) -> Superellipse:
        """The plan of both surfaces, for a half width of 1 along x: the section along x is carried round it."""
        return Superellipse(1.0, 2.0)

    @property
    def rim_thickness(self) -> float:
        """Thickness of the wall at the rim, along the normal, mm; that at the apex unless a skin says otherwise."""
        return self.thickness

    def reach(self, azimuth: ArrayLike) -> FloatArray:
        """Greatest distance (...) mm of the inner surface from the axis at azimuths (...) in rad."""
        return np.full(np.shape(azimuth), self.widest[0])

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """Return the skin with every length multiplied."""

    @abstractmethod
    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        """Points (n, 3) mm at places (n, 2) of the unit disc; `layer` 0 is the inner surface, 1 the outer."""

    def marked(self, disc: FloatArray) -> FloatArray:
        """Points (n, 3) mm of the marked surface at places (n, 2) of the unit disc: inner surface, or tips of pins.

        What follows is about the marked surface.
        """
        return self.point(disc, 0.0)

    @abstractmethod
    def disc(self, points: FloatArray) -> FloatArray:
        """Places (n, 2) on the unit disc of points (n, 3) mm near the marked surface; beyond 1 below the rim."""

    @abstractmethod
    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        """Points of the base plane carried along the axis to the inner surface, the upper crossing where it bulges.

        Parameters
        ----------
        rho
            (...) distance from the axis, mm.
        azimuth
            (...) angle about the axis from x, rad.

        Returns
        -------
        ndarray
            (..., 3) mm; z is NaN where `rho` is beyond the skin's widest circle.
        """

    def tangents(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Normal, and unit vectors along the meridian away from the apex and along the circle, (n, 3) each.

        At the apex, where there is no meridian, they are those towards x and y.
        """
        normals = self.normal(points)
        circle = np.cross([0.0, 0.0, 1.0], normals)
        length = np.linalg.norm(circle, axis=1, keepdims=True)
        circle = np.where(length < _AT_APEX, [[0.0, 1.0, 0.0]], circle / np.maximum(length, _AT_APEX))
        return normals, np.cross(circle, normals), circle

    @abstractmethod
    def normal(self, points: FloatArray) -> FloatArray:
        """Outward unit normal (..., 3) of the inner surface at points (..., 3) mm on or near it."""

    @abstractmethod
    def nearest(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) mm of the inner surface nearest to points (..., 3) mm: put back on the surface."""

    @abstractmethod
    def distance(self, points: ArrayLike) -> FloatArray:
        """Signed distance (...) mm of points (..., 3) mm from the inner surface, positive outward."""

    @abstractmethod
    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        """Distance (...) mm along the meridian from points (..., 3) mm of the inner surface to the rim."""

    @abstractmethod
    def arc_length(self, points: FloatArray) -> FloatArray:
        """Distance (n,) mm along the meridian from the apex to points (n, 3) mm of the inner surface."""

    @abstractmethod
    def at_arc_length(self, length: FloatArray) -> FloatArray:
        """Distance (n,) mm from the axis of the points so far (n,) mm along the meridian from the apex."""

    @abstractmethod
    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        """Points (n, 3) mm where rays (n, 3) leave the inner surface; NaN if they miss.

        They come from one origin (3,) mm, or each from its own (n, 3).
        """

    @abstractmethod
    def support_point(self, normal: FloatArray) -> FloatArray:
        """First point (3,) mm of the outer surface that a wall with this outward normal (3,) touches."""

    def support_height(self, normals: FloatArray) -> FloatArray:
        """Heights (n,) mm at which walls with these outward normals (n, 3) cross the axis when they first touch."""
        return np.array([self.support_point(normal) @ normal / normal[2] for normal in normals])

    @property
    @abstractmethod
    def inner_slope(self) -> float:
        """Angle in rad between the axis and the inner surface's normal at its rim; above π/2 where it bulges."""

    @abstractmethod
    def rim_slope(self, rim: Rim) -> float:
        """Angle in rad between the axis and the outer normal at its rim: a wall tilted so far touches the clamp."""

    @abstractmethod
    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        """Depth in mm at which a wall of this tilt (rad) reaches the clamped outer rim."""

    @abstractmethod
    def meridian(self, offset: float, *, down: bool) -> Outline:
        """Half section (x, z) mm of the surface `offset` mm outside the inner one, apex to base (`down`) or back.

        It is that along x. Its first point is left out, for an outline goes on from where it stands. Of a wall that
        is not even, an offset above 0 is that at the apex, and elsewhere in proportion.
        """

    def solid(self, outline: Outline) -> CadSolid:
        """The body whose half section along x is an outline of (x, z) mm, carried round the plan."""
        return revolve(outline) if self.plan.is_round else loft(outline, self.plan.edge)

    @property
    def bulges(self) -> bool:
        """Whether the inner surface is wider somewhere than at its rim, so that a rigid core cannot be pulled."""
        return self.widest[0] > self.base_radius * (1 + 1e-12)

    @property
    def outer_widest(self) -> tuple[float, float]:
        """Greatest distance of the outer surface from the axis and its height over the base, mm."""
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
        """Refuse to go on where a body of revolution with an apex is needed and this is none.

        Raises
        ------
        PalpateError
            With the reason `why`, a part of a sentence, the remedy, and the code of what is asked for.
        """
        if self.symmetry is not Symmetry.REVOLVED:
            raise PalpateError(f"{self.name} is no body of revolution: {why}.", remedy, code=code)
        if self.hole:
            raise PalpateError(
                f"{self.name} has no apex: as yet a barrel is pressed, seen, learnt and made, no more.",
                remedy,
                code="skin-no-apex",
            )
