"""Blind holes in the core of a mold, for the pins of a skin or the dots of a barrel."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.design import CadSolid, MarkerLayout, Skin, cylinder, place_orientation_mark

_INTO_WALL = 0.25
"""Extension of a pin into the skin, over its thickness, so that no gap is left at its root."""


def build_pins(skin: Skin, layout: MarkerLayout, scale: float, *, mark: bool) -> list[CadSolid]:
    """Build the scaled pins of a skin, with `mark` that of the orientation mark too; may be empty."""
    if not skin.pin:
        return []
    tips = _places(skin, layout, mark=mark)
    return _stand(skin, tips, layout.diameter, skin.pin, scale)


def build_dimples(skin: Skin, layout: MarkerLayout, depth: float, scale: float, *, mark: bool) -> list[CadSolid]:
    """Build the scaled dots of a barrel, `depth` mm inward from its surface; empty for other skins."""
    if not skin.hole:
        return []
    points = _places(skin, layout, mark=mark)
    return _stand(skin, points - depth * skin.normal(points), layout.diameter, depth, scale)


def _places(skin: Skin, layout: MarkerLayout, *, mark: bool) -> FloatArray:
    return np.vstack([layout.positions, place_orientation_mark(skin, layout)]) if mark else layout.positions


def _stand(skin: Skin, tips: FloatArray, diameter: float, length: float, scale: float) -> list[CadSolid]:
    """Build cylinders from tips (n, 3) mm along the normals, of a length in mm, extended into the skin."""
    normals = skin.normal(tips)
    polar, azimuth = np.degrees(np.arccos(normals[:, 2])), np.degrees(np.arctan2(normals[:, 1], normals[:, 0]))
    upright = cylinder(scale * diameter / 2, 0.0, scale * (length + _INTO_WALL * skin.thickness))
    return [
        upright.turned("y", float(lean)).turned("z", float(turn)).moved(*(scale * tip))
        for tip, lean, turn in zip(tips, polar, azimuth, strict=True)
    ]
