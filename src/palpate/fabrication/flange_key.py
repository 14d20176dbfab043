"""Rotational datum: a notch in the flange's edge, cast by a rib of the cavity, and the housing's key.

It is opposite the cable slot. The artwork has a long stroke and the template a notch on its side.
"""

from __future__ import annotations

from palpate.design import CadSolid, ContactModule, cylinder

NOTCH_AZIMUTH_DEG = 270.0
"""Azimuth of the notch, opposite the cable slot and between two vents."""
_RADIUS, _SHARE = 1.5, 0.35
"""Radius of a notch, mm; at most this share of the flange's width, of which the clamp ring covers 0.6."""
_TALL = 2 / 3
"""Height of the key over the flange's thickness, so that the clamp ring meets the flange only."""


def notch_radius(module: ContactModule) -> float:
    """Return the radius of the notch, mm."""
    return min(_RADIUS, _SHARE * (module.flange_radius - module.widest))


def build_notch(module: ContactModule) -> CadSolid:
    """Build the cylinder about the edge of the flange's foot that is cut from the flange."""
    return cylinder(notch_radius(module), module.foot, 0.0, module.place(module.flange_foot, NOTCH_AZIMUTH_DEG))


def build_key(module: ContactModule, clearance: float) -> CadSolid:
    """Build the key on the seat of the flange, with a clearance in mm to the notch."""
    low, high = module.foot - 1, module.foot + _TALL * module.flange_thickness
    at = module.place(module.flange_foot, NOTCH_AZIMUTH_DEG)
    key = cylinder(notch_radius(module) - clearance, low, high, at)
    return key.common(module.prism(module.flange_foot, low, high))
