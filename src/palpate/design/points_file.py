"""Free layouts and followed points: tables with the columns x, y and z and their unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.core.tables import named_table
from palpate.core.units import split_unit
from palpate.design.skin import Skin

_MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "µm": 1e-3, "in": 25.4}
"""mm a unit."""
ON_SURFACE = 0.05
"""A point given with its height must lie this near the inner surface, mm."""


def read_points(path: Path, skin: Skin) -> FloatArray:
    """Read points of the inner surface from a table with a header.

    Parameters
    ----------
    path
        Table with the columns ``x_mm, y_mm`` and, if wished, ``z_mm``, in any order, unit and dialect.
    skin
        The dome that carries the points. Without ``z_mm`` a point is carried up along the axis.

    Returns
    -------
    ndarray
        (n, 3) points, mm; z is NaN where a point without ``z_mm`` is outside the dome.

    Raises
    ------
    PalpateError
        If the file is missing, is no such table, or a height in it is off the inner surface; the message
        names the line.
    """
    table = _read_table(path)
    if table.shape[1] == 2:
        return skin.inner_point(np.hypot(table[:, 0], table[:, 1]), np.arctan2(table[:, 1], table[:, 0]))
    off = np.abs(skin.distance(table))
    below = skin.distance_to_rim(table) < -ON_SURFACE
    for row in np.flatnonzero((off > ON_SURFACE) | below):
        where = "below the base plane" if below[row] else f"{off[row]:.3g} mm off the inner surface"
        raise PalpateError(
            f"{path}: point {row + 1} ({', '.join(f'{value:g}' for value in table[row])}) mm is {where}.",
            f"The inner surface is that of {skin.name}, z >= 0; leave out z_mm to have points carried there.",
            code="point-below-base" if below[row] else "point-off-surface",
        )
    return table


def _read_table(path: Path) -> FloatArray:
    """(n, 2) or (n, 3) x, y and, if the file has it, z, mm."""
    table = named_table(path)
    found: dict[str, FloatArray] = {}
    for at, name in enumerate(table.header):
        axis, unit = split_unit(name.lower())[0], table.unit(at).lower()
        if axis not in ("x", "y", "z"):
            continue
        if unit not in _MM:
            raise PalpateError(
                f"{path}: column {name} has the unit '{unit}'." if unit else f"{path}: column {name} has no unit.",
                f"Write x_mm,y_mm; units are {', '.join(_MM)}.",
                code="columns-wrong",
            )
        numbers = table.numbers(at) if table.is_numeric(at) else np.full(len(table), np.nan)
        if not np.isfinite(numbers).all():
            row = int(np.argmax(~np.isfinite(numbers)))
            text = table.faults[at].text if at in table.faults else str(table.columns[at][row])
            raise PalpateError(
                f"{path}:{table.lines[row]}: {name} is '{text}', no number.", "Write numbers.", code="row-not-numbers"
            )
        found[axis] = _MM[unit] * numbers
    if not {"x", "y"} <= set(found):
        raise PalpateError(
            f"{path} has the columns {', '.join(table.header)}.",
            "They must be x_mm, y_mm and, if wished, z_mm.",
            code="columns-wrong",
        )
    return np.stack([found[axis] for axis in sorted(found)], axis=1)
