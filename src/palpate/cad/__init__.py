"""Cad: outlines, and the solids that are revolved and extruded from them. The only room that knows the CAD kernel."""

from palpate.cad.outline import Arc, Outline, Point, SmoothCurve
from palpate.cad.solid import CadSolid, SurfaceMesh, box, cylinder, extrude, gather, read_step, revolve, write_step

__all__ = [
    "Arc",
    "CadSolid",
    "Outline",
    "Point",
    "SmoothCurve",
    "SurfaceMesh",
    "box",
    "cylinder",
    "extrude",
    "gather",
    "read_step",
    "revolve",
    "write_step",
]
