"""Type, unit and meaning of each table column, for the data card and the Croissant metadata."""

from __future__ import annotations

from typing import NamedTuple

from palpate_benchmark.set_files import MADE

_UNITS = {"distance": "mm", "focal": "1", "k1": "1", "thickness": "mm", "modulus": "1", "missing": "1"}
_MEANS = {
    "modulus": "share by which the elastomer is too stiff",
    "offset_x": "camera off the axis along x",
    "offset_y": "camera off the axis along y",
    "distance": "camera too far away",
    "tilt_x_deg": "camera's tilt about x",
    "tilt_y_deg": "camera's tilt about y",
    "roll_deg": "camera's turn about its axis",
    "focal": "relative excess of the focal length",
    "centre_x_px": "deviation of the image centre, column",
    "centre_y_px": "deviation of the image centre, row",
    "k1": "first coefficient of the distortion",
    "thickness": "excess of the skin thickness",
    "print_shift_x": "shift of the print along x",
    "print_shift_y": "shift of the print along y",
    "missing": "share of missing markers",
}


class Column(NamedTuple):
    """One column: name, Croissant type, unit and meaning."""

    name: str
    kind: str
    unit: str
    meaning: str


IMAGE = Column("image", "sc:Integer", "1", "number of the image, in a random order over the whole set")
SIGHT = (
    IMAGE,
    Column("design", "sc:Text", "", "name of the design, see designs.csv"),
    Column("unit", "sc:Integer", "1", "number of the built unit, within its design"),
    Column("picture", "sc:Text", "", "name of the rendered image in the split's archive; empty without one"),
)
LABEL = (
    Column("press", "sc:Integer", "1", "number of the press: one wall pose and friction, one state of the skin"),
    Column("rx_deg", "sc:Float", "deg", "rotation vector of the wall about the dome's x, in the unit's own frame"),
    Column("ry_deg", "sc:Float", "deg", "the same about y"),
    Column("depth_mm", "sc:Float", "mm", "travel of the wall along the dome's axis since first contact"),
    Column("force_n", "sc:Float", "N", "force of the dome on the wall along the wall's normal"),
    Column("shear_n", "sc:Float", "N", "magnitude of the force in the wall's plane"),
    Column("friction", "sc:Float", "1", "coefficient of friction between dome and wall; inf: no slip"),
    Column("branch", "sc:Text", "", "flat or inverted"),
)
DESIGN = (
    Column("design", "sc:Text", "", "name of the design"),
    Column("height_mm", "sc:Float", "mm", "height of the inner surface's apex over the base"),
    Column("thickness_mm", "sc:Float", "mm", "skin thickness"),
    Column("base_radius_mm", "sc:Float", "mm", "radius of the inner surface's rim"),
    Column("markers", "sc:Integer", "1", "number of markers"),
    Column("dot_diameter_mm", "sc:Float", "mm", "diameter of a marker"),
)
DOT = (
    Column("design", "sc:Text", "", "name of the design"),
    Column("marker", "sc:Integer", "1", "number of the marker: its row in markers_px"),
    Column("x_mm", "sc:Float", "mm", "position on the undeformed inner surface, x"),
    Column("y_mm", "sc:Float", "mm", "the same along y"),
    Column("z_mm", "sc:Float", "mm", "the same along the dome's axis, from the base up"),
)


def _unit_of(name: str) -> str:
    endings = {"_deg": "deg", "_px": "px", "_x": "mm", "_y": "mm"}
    return _UNITS.get(name) or next(unit for end, unit in endings.items() if name.endswith(end))


BUILT = (
    Column("design", "sc:Text", "", "name of the design"),
    Column("unit", "sc:Integer", "1", "number of the built unit"),
    *(Column(name, "sc:Float", _unit_of(name), f"{_MEANS[name]}, over the design") for name in MADE),
)
TABLES: dict[str, tuple[Column, ...]] = {
    "train.csv": (*SIGHT, *LABEL),
    "calibrate.csv": (*SIGHT, *LABEL),
    "test.csv": SIGHT,
    "hidden.csv": (IMAGE, *LABEL),
    "designs.csv": DESIGN,
    "layouts.csv": DOT,
    "train_units.csv": BUILT,
    "calibrate_units.csv": BUILT,
    "hidden_units.csv": BUILT,
}
"""Every table of the set and its columns."""
