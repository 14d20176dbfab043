"""The template: a thin shell set into the dome, with a hole at every marker, for those without a pad printer."""

from __future__ import annotations

import numpy as np

from palpate.core import PalpateError
from palpate.design import (
    Dome,
    DomeShape,
    MarkerLayout,
    SurfaceMesh,
    follow_meridian,
    place_orientation_mark,
    revolve,
)
from palpate.fabricate.mesh_file import drill
from palpate.fabricate.spec import ProcessSpec

THICKNESS = 1.2
"""Of the shell, mm."""


def build_template(dome: Dome, layout: MarkerLayout, spec: ProcessSpec) -> SurfaceMesh:
    """Build the shell, a gap smaller than the dome's inside, with a hole along the normal at every marker.

    Raises
    ------
    PalpateError
        If it could not be set into a dome that bulges, or neighbouring holes would leave too little between them.
    """
    if dome.shape is DomeShape.CAP:
        raise PalpateError(
            f"A template is {2 * dome.radius:.4g} mm wide and does not pass a base of {2 * dome.base_radius:g} mm.",
            "Print by the pad.",
        )
    pair = layout.closest_pair()
    web = np.inf if pair is None else pair[2] * (1 - THICKNESS / dome.radius) - layout.diameter
    if web < spec.printer_wall / 2:
        raise PalpateError(
            f"Holes of a template would stand {web:.2g} mm apart; the printer needs {spec.printer_wall / 2:g} mm.",
            "Take smaller dots, fewer markers, or the pad.",
        )
    points = layout.positions
    if spec.orientation_mark:
        points = np.vstack([points, place_orientation_mark(dome, layout)])
    center, radius = np.array([0.0, 0.0, dome.center_z]), dome.radius - spec.clearance
    out = (points - center) / np.linalg.norm(points - center, axis=1, keepdims=True)
    outside = follow_meridian(dome, radius, down=True)
    inside = follow_meridian(dome, radius - THICKNESS, down=False)
    foot = (float(np.sqrt((radius - THICKNESS) ** 2 - dome.center_z**2)), 0.0)
    shell = revolve([(0.0, dome.center_z + radius), outside, foot, inside]).mesh()
    return drill(shell, center + (radius - 3 * THICKNESS) * out, center + (radius + THICKNESS) * out, layout.diameter)
