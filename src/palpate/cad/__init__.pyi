"""Cad: outlines, and the solids that are made from them. The only room that knows the CAD kernel."""

from palpate.cad.outline import Arc, Outline, Plan, Point, SmoothCurve
from palpate.cad.solid import (
    CadSolid,
    SurfaceMesh,
    box,
    cylinder,
    extrude,
    gather,
    loft,
    read_step,
    revolve,
    write_step,
)

__all__ = [
    "Arc",
    "CadSolid",
    "Outline",
    "Plan",
    "Point",
    "SmoothCurve",
    "SurfaceMesh",
    "box",
    "cylinder",
    "extrude",
    "gather",
    "loft",
    "read_step",
    "revolve",
    "write_step",
]
