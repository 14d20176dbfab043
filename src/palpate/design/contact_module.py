"""The contact module: a skin and the flange by which it is clamped, cast in one piece.

         .-''''-.
       .'  .--.  '.          outer and inner sphere of the dome
      /  .'    '.  \\
     |  |        |  |
    _|__|        |__|_       z = 0
   /___|          |___\\      flange, its edges drafted
       <--- B --->

All of it is the section along x, carried round the plan of the skin: turned, or stretched round a pad's. A barrel,
open at its far end too, has the same flange there, upside down.
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
    skin
        The skin, possibly scaled.
    flange_thickness
        From z = 0 down.
    flange_radius, opening_radius
        Outer edge and opening at z = 0.
    flange_foot, opening_foot
        The same at the foot of the flange, wider by the draft.
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
        """How much farther from the axis a point of the section may come than it is along x."""
        return self.skin.plan.farthest

    @property
    def widest(self) -> float:
        """Greatest distance from the axis of the section's outer surface over the flange, mm."""
        skin = self.skin
        return (skin.outer_base_radius if skin.hole else skin.outer_widest[0]) / self.farthest

    @property
    def top(self) -> float:
        """Height of the apex, or of the far face of the far end's flange, mm."""
        return self.skin.outer_height + (self.flange_thickness if self.skin.hole else 0.0)

    def place(self, reach: float, azimuth_deg: float) -> Point:
        """Where a point of the section, so far from the axis (mm), is carried: at an angle of the plan."""
        x, y = reach * self.skin.plan.edge(np.radians([azimuth_deg]))[0][0]
        return float(x), float(y)

    def solid(self, outline: Outline | None = None) -> CadSolid:
        """The solid of half a section, (x, z) mm; without one, the body of the module."""
        return self.skin.solid(self.outline() if outline is None else outline)

    def prism(self, reach: float, low: float, high: float) -> CadSolid:
        """What lies within the plan up to `reach` along x and between two heights, mm."""
        return self.solid([(0.0, low), (reach, low), (reach, high), (0.0, high)])

    def outline(self) -> Outline:
        """Half the section of the module, (x, z) mm."""
        far = [(self.opening_foot, self.top)] if self.skin.hole else []
        return [
            *self._upper(),
            (self.opening_foot, self.foot),
            (self.opening_radius, 0.0),
            *self.skin.meridian(0.0, down=False),
            *far,
        ]

    def _upper(self) -> Outline:
        """The outer surface from its apex, or from the far flange's face, and the flange's edge down to its foot."""
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
        """Half the section of all that lies within the outer surface."""
        far = [(0.0, self.top)] if self.skin.hole else []
        return [*far, *self._upper(), (0.0, self.foot)]

    def inside(self) -> Outline:
        """Half the section of the hollow."""
        skin = self.skin
        far: Outline = [(0.0, skin.height)]
        if skin.hole:
            far = [(0.0, self.top), (self.opening_foot, self.top), (self.opening_radius, skin.height)]
        return [*far, *skin.meridian(0.0, down=True), (self.opening_foot, self.foot), (0.0, self.foot)]


def build_contact_module(skin: Skin, mount: MountSpec, scale: float = 1.0) -> ContactModule:
    """Lay out a module.

    Parameters
    ----------
    skin
        Its dome.
    mount
        Its flange.
    scale
        Factor on every length, for a mold whose part shrinks.

    Raises
    ------
    PalpateError
        If the skin is no body of revolution and without a plan.

    Examples
    --------
    >>> from palpate.design import DomeSpec, build_skin
    >>> module = build_contact_module(build_skin(DomeSpec(height=20)), MountSpec())
    >>> module.foot, module.outline()[0]
    (-3.0, (0.0, 22.0))
    """
    if type(skin).plan is Skin.plan and skin.symmetry is not Symmetry.REVOLVED:
        skin.require_revolution("its flange and its mold would be turned", "Give its class a `plan`.")
    skin = skin.scaled(scale)
    thickness = scale * mount.flange_thickness
    outer = skin.outer_base_radius + scale * mount.flange_width
    draft = thickness * float(np.tan(np.radians(mount.draft_deg)))
    return ContactModule(skin, thickness, outer, skin.base_radius, outer + draft, skin.base_radius + draft)
