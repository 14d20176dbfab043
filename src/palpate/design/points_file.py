"""Points of free layouts and tracked points, from tables or circles of drawings."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.core.tables import named_table
from palpate.core.units import split_unit
from palpate.design.drawing_points import DRAWINGS, read_circles
from palpate.design.skin import Skin

MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "µm": 1e-3, "in": 25.4}
"""Length of each unit in mm."""
ON_SURFACE = 0.05
"""Maximum distance from the inner surface of a point with a height, mm. By hand."""


def read_points(path: Path, skin: Skin) -> FloatArray:
    """Read points (n, 3) mm of the inner surface from a table, or from the circles of a drawing.

    The columns of a table are ``x_mm, y_mm`` and optionally ``z_mm``, in any order, unit and dialect. A point without
    ``z_mm``, and a circle of a DXF or SVG file (`read_circles`), is projected along the axis; outside the skin its z
    is NaN.

    Raises
    ------
    PalpateError
        If the file is missing or not such a table, or a point is not on the inner surface; the message contains the
        line.
    """
    table = read_circles(path) if path.suffix.lower() in DRAWINGS else _read_table(path)
    if table.shape[1] == 2:
        return skin.inner_point(np.hypot(table[:, 0], table[:, 1]), np.arctan2(table[:, 1], table[:, 0]))
    off = np.abs(skin.distance(table))
    below = skin.distance_to_rim(table) < -ON_SURFACE
    for row in np.flatnonzero((off > ON_SURFACE) | below):
        where = "below the base plane" if below[row] else f"{off[row]:.3g} mm from the inner surface"
        raise PalpateError(
            f"{path}: point {row + 1} ({', '.join(f'{value:g}' for value in table[row])}) mm is {where}.",
            f"The inner surface is that of {skin.name}, z >= 0; leave out z_mm to project points onto it.",
            code="point-below-base" if below[row] else "point-off-surface",
        )
    return table


def _read_table(path: Path) -> FloatArray:
    """Return x, y and, if the file has it, z, mm: (n, 2) or (n, 3)."""
    table = named_table(path)
    found: dict[str, FloatArray] = {}
    for at, name in enumerate(table.header):
        axis, unit = split_unit(name.lower())[0], table.unit(at).lower()
        if axis not in ("x", "y", "z"):
            continue
        if unit not in MM:
            raise PalpateError(
                f"{path}: column {name} has the unit '{unit}'." if unit else f"{path}: column {name} has no unit.",
                f"Write x_mm,y_mm; units are {', '.join(MM)}.",
                code="columns-wrong",
            )
        numbers = table.numbers(at) if table.is_numeric(at) else np.full(len(table), np.nan)
        if not np.isfinite(numbers).all():
            row = int(np.argmax(~np.isfinite(numbers)))
            text = table.faults[at].text if at in table.faults else str(table.columns[at][row])
            raise PalpateError(
                f"{path}:{table.lines[row]}: {name} is '{text}', not a number.",
                "Write numbers.",
                code="row-not-numbers",
            )
        found[axis] = MM[unit] * numbers
    if not {"x", "y"} <= set(found):
        raise PalpateError(
            f"{path} has the columns {', '.join(table.header)}.",
            "The required columns are x_mm, y_mm and optionally z_mm.",
            code="columns-wrong",
        )
    return np.stack([found[axis] for axis in sorted(found)], axis=1)
