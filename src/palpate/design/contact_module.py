"""Contact module: a skin and its clamping flange, cast in one piece.

         .-''''-.
       .'  .--.  '.          outer and inner sphere of the dome
      /  .'    '.  \\
     |  |        |  |
    _|__|        |__|_       z = 0
   /___|          |___\\      flange, its edges drafted
       <--- B --->

The module is the section along x, swept around the plan of the skin: revolved, or stretched to the plan of a pad. A
barrel, which is also open at its far end, has the same flange there, upside down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.design.outline import Outline, Point
from palpate.design.skin import Skin, Symmetry
from palpate.design.solid import CadSolid
from palpate.design.spec import MountSpec


@dataclass(frozen=True)
class ContactModule:
    """Dimensions of a contact module, mm, of its section along x.

    Attributes
    ----------
    skin, flange_thickness
        The skin, possibly scaled, and the flange's thickness downward from z = 0.
    flange_radius, opening_radius
        Outer edge and opening at z = 0.
    flange_foot, opening_foot
        Outer edge and opening at the foot of the flange, wider by the draft.
    """

    skin: Skin
    flange_thickness: float
    flange_radius: float
    opening_radius: float
    flange_foot: float
    opening_foot: float

    @property
    def foot(self) -> float:
        """Height of the foot of the flange, mm, negative."""
        return -self.flange_thickness

    @property
    def farthest(self) -> float:
        """Maximum ratio of a swept point's distance from the axis to that along x."""
        return self.skin.plan.farthest

    @property
    def widest(self) -> float:
        """Maximum distance from the axis of the section's outer surface above the flange, mm."""
        skin = self.skin
        return (skin.outer_base_radius if skin.hole else skin.outer_widest[0]) / self.farthest

    @property
    def top(self) -> float:
        """Height of the apex, or of the outer face of the far end's flange, mm."""
        return self.skin.outer_height + (self.flange_thickness if self.skin.hole else 0.0)

    def place(self, reach: float, azimuth_deg: float) -> Point:
        """Return (x, y) of a point of the section, by its distance from the axis (mm) and angle of the plan."""
        x, y = reach * self.skin.plan.edge(np.radians([azimuth_deg]))[0][0]
        return float(x), float(y)

    def solid(self, outline: Outline | None = None) -> CadSolid:
        """Sweep half a section, (x, z) mm, to a solid; by default that of the module."""
        return self.skin.solid(self.outline() if outline is None else outline)

    def prism(self, reach: float, low: float, high: float) -> CadSolid:
        """Return the solid inside the plan up to `reach` along x, between two heights, mm."""
        return self.solid([(0.0, low), (reach, low), (reach, high), (0.0, high)])

    def outline(self) -> Outline:
        """Return half the section of the module, (x, z) mm."""
        far = [(self.opening_foot, self.top)] if self.skin.hole else []
        return [
            *self._upper(),
            (self.opening_foot, self.foot),
            (self.opening_radius, 0.0),
            *self.skin.meridian(0.0, down=False),
            *far,
        ]

    def _upper(self) -> Outline:
        """Return the outer surface from its apex or far flange, and the flange's edge down to its foot."""
        skin = self.skin
        outer = skin.meridian(skin.thickness, down=True)
        far: Outline = [(0.0, skin.outer_height)]
        if skin.hole:
            far = [
                (self.flange_foot, self.top),
                (self.flange_radius, skin.height),
                (skin.outer_base_radius, skin.height),
            ]
        return [*far, *outer, (self.flange_radius, 0.0), (self.flange_foot, self.foot)]

    def outside(self) -> Outline:
        """Return half the section of everything inside the outer surface."""
        far = [(0.0, self.top)] if self.skin.hole else []
        return [*far, *self._upper(), (0.0, self.foot)]

    def inside(self) -> Outline:
        """Return half the section of the cavity."""
        skin = self.skin
        far: Outline = [(0.0, skin.height)]
        if skin.hole:
            far = [(0.0, self.top), (self.opening_foot, self.top), (self.opening_radius, skin.height)]
        return [*far, *skin.meridian(0.0, down=True), (self.opening_foot, self.foot), (0.0, self.foot)]


def build_contact_module(skin: Skin, mount: MountSpec, scale: float = 1.0) -> ContactModule:
    """Build the dimensions of a contact module from its skin and flange.

    `scale` multiplies every length, for a mold whose part shrinks.

    Raises
    ------
    PalpateError
        If the skin is not a body of revolution and has no plan.

    Examples
    --------
    >>> from palpate.design import DomeSpec, build_skin
    >>> module = build_contact_module(build_skin(DomeSpec(height=20)), MountSpec())
    >>> module.foot, module.outline()[0]
    (-3.0, (0.0, 22.0))
    """
    if type(skin).plan is Skin.plan and skin.symmetry is not Symmetry.REVOLVED:
        skin.require_revolution("its flange and its mold are revolved", "Give its class a `plan`.")
    skin = skin.scaled(scale)
    thickness = scale * mount.flange_thickness
    outer = skin.outer_base_radius + scale * mount.flange_width
    draft = thickness * float(np.tan(np.radians(mount.draft_deg)))
    return ContactModule(skin, thickness, outer, skin.base_radius, outer + draft, skin.base_radius + draft)
