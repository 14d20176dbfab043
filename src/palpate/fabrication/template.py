"""Template: a thin shell inside the dome with a hole at every marker, instead of a pad printer."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import Arc, MarkerLayout, Outline, Skin, SmoothCurve, SurfaceMesh, place_orientation_mark
from palpate.fabrication.flange_key import NOTCH_AZIMUTH_DEG
from palpate.fabrication.mesh_file import drill
from palpate.fabrication.spec import ProcessSpec

THICKNESS = 1.2
"""Thickness of the shell, mm."""


def build_template(skin: Skin, layout: MarkerLayout, spec: ProcessSpec) -> SurfaceMesh:
    """Build the shell, with a gap to the inner surface, and a hole along the normal at every marker.

    A notch in its foot is on the side of the flange's notch.

    Raises
    ------
    PalpateError
        If it does not fit into a bulging dome or under a sharp edge, or the holes are too near to each other.
    """
    if skin.pin:
        raise PalpateError(
            "Pins are cast with the skin, so no template is needed.",
            "Paint their tips.",
            code="template-not-for-pins",
        )
    if skin.bulges:
        raise PalpateError(
            f"A template {2 * skin.widest[0]:.4g} mm wide does not pass a base of {2 * skin.base_radius:g} mm.",
            "Use a pad printer.",
            code="template-too-wide",
        )
    out, top = skin.normal(layout.positions), -spec.clearance
    pair = MarkerLayout(layout.positions - THICKNESS * out, layout.diameter).closest_pair()
    web = np.inf if pair is None else pair[2] - layout.diameter
    if web < spec.printer_wall / 2:
        raise PalpateError(
            f"Holes of a template would be {web:.2g} mm apart; the printer needs {spec.printer_wall / 2:g} mm.",
            "Use smaller dots, fewer markers, or a pad printer.",
            code="template-holes-too-near",
        )
    points = layout.positions
    if spec.orientation_mark:
        points = np.vstack([points, place_orientation_mark(skin, layout)])
        out = skin.normal(points)
    outside = skin.meridian(top, down=True)
    foot = _end(skin.meridian(top - THICKNESS, down=True))
    back = skin.meridian(top - THICKNESS, down=False)
    if isinstance(back[0], SmoothCurve) and not skin.plan.is_round:
        raise PalpateError(
            f"A template {THICKNESS:g} mm thick does not fit under an edge of {skin.radius:g} mm.",
            f"Use an edge of more than {spec.clearance + THICKNESS:g} mm, or a pad printer.",
            code="template-edge-too-tight",
        )
    shell = skin.solid([(0.0, skin.height + top), *outside, (foot, 0.0), *back]).mesh()
    start, end = points + (top - 3 * THICKNESS) * out, points + (top + THICKNESS) * out
    x, y = _end(outside) * _datum(skin)
    start, end = np.vstack([start, [x, y, -THICKNESS]]), np.vstack([end, [x, y, THICKNESS]])
    return drill(shell, start, end, layout.diameter)


def _datum(skin: Skin) -> FloatArray:
    """Return the point (2,) of the plan at the azimuth of the flange's notch."""
    return skin.plan.edge(np.radians([NOTCH_AZIMUTH_DEG]))[0][0]


def _end(outline: Outline) -> float:
    """Return the distance from the axis of the end of an outline, mm."""
    item = outline[-1]
    return float(
        (item.end if isinstance(item, Arc) else item.through[-1] if isinstance(item, SmoothCurve) else item)[0]
    )
