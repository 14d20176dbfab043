"""Cad: outlines, and the solids that are revolved and extruded from them. The only room that knows the CAD kernel."""

from palpate.cad.outline import Arc, Curve, Outline, Point
from palpate.cad.solid import Solid, SurfaceMesh, box, cylinder, extrude, gather, read_step, revolve, write_step

__all__ = [
    "Arc",
    "Curve",
    "Outline",
    "Point",
    "Solid",
    "SurfaceMesh",
    "box",
    "cylinder",
    "extrude",
    "gather",
    "read_step",
    "revolve",
    "write_step",
]
