"""Design: from height, base radius, thickness and markers to the geometry of a dome and its limits."""

from palpate.design.build_dome import build_dome
from palpate.design.check_design import check_design, refuse_errors
from palpate.design.dome import Dome, DomeShape
from palpate.design.finding import Finding, Severity
from palpate.design.markers import MarkerLayout
from palpate.design.place_markers import place_markers
from palpate.design.points_file import read_points
from palpate.design.rings import ring_count, ring_diameters
from palpate.design.spec import DomeSpec, MarkerSpec

__all__ = [
    "Dome",
    "DomeShape",
    "DomeSpec",
    "Finding",
    "MarkerLayout",
    "MarkerSpec",
    "Severity",
    "build_dome",
    "check_design",
    "place_markers",
    "read_points",
    "refuse_errors",
    "ring_count",
    "ring_diameters",
]
