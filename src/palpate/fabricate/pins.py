"""Pins inside a skin: blind holes in the core of its mold, which the elastomer fills."""

from __future__ import annotations

import numpy as np

from palpate.cad import CadSolid, cylinder
from palpate.design import MarkerLayout, Skin, place_orientation_mark

_INTO_WALL = 0.25
"""How far a pin is drawn into the wall, over its thickness, so that no gap is left at its root."""


def build_pins(skin: Skin, layout: MarkerLayout, scale: float, *, mark: bool) -> list[CadSolid]:
    """The pins of a skin, every length times a scale, with `mark` that of the orientation mark too; or none."""
    if not skin.pin:
        return []
    tips = np.vstack([layout.positions, place_orientation_mark(skin, layout)]) if mark else layout.positions
    long = skin.pin + _INTO_WALL * skin.thickness
    normals = skin.normal(tips)
    polar, azimuth = np.degrees(np.arccos(normals[:, 2])), np.degrees(np.arctan2(normals[:, 1], normals[:, 0]))
    upright = cylinder(scale * layout.diameter / 2, 0.0, scale * long)
    return [
        upright.turned("y", float(lean)).turned("z", float(turn)).moved(*(scale * tip))
        for tip, lean, turn in zip(tips, polar, azimuth, strict=True)
    ]
