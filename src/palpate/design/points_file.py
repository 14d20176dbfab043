"""Free layouts and followed points: CSV files with the columns x_mm, y_mm and z_mm."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design.skin import Skin

ON_SURFACE = 0.05
"""A point given with its height must lie this near the inner surface, mm."""


def read_points(path: Path, skin: Skin) -> FloatArray:
    """Read points of the inner surface from a CSV file with a header.

    Parameters
    ----------
    path
        File with the columns ``x_mm, y_mm`` and, if wished, ``z_mm``, in any order.
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
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [(number, row) for number, row in enumerate(csv.reader(file), start=1) if any(row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text table"
        raise PalpateError(
            f"{path} cannot be read: {reason}.", "Give a CSV file of points.", code="file-unreadable"
        ) from error
    header = [name.strip() for name in rows[0][1]] if rows else []
    if sorted(header) not in (["x_mm", "y_mm"], ["x_mm", "y_mm", "z_mm"]):
        raise PalpateError(
            f"{path} has the columns {', '.join(header) or '(none)'}.",
            "They must be x_mm,y_mm or x_mm,y_mm,z_mm.",
            code="columns-wrong",
        )
    if len(rows) == 1:
        raise PalpateError(f"{path} has no points under its header.", "Give one point a line.", code="table-empty")
    order = [header.index(name) for name in sorted(header)]
    return np.array([_numbers(path, number, row, order) for number, row in rows[1:]])


def _numbers(path: Path, line: int, row: list[str], order: list[int]) -> list[float]:
    try:
        numbers = [float(row[column]) for column in order]
    except (ValueError, IndexError):
        numbers = []
    if len(row) != len(order) or not np.all(np.isfinite(numbers)) or not numbers:
        raise PalpateError(
            f"{path}:{line}: {','.join(row)} is not {len(order)} numbers.",
            "Write them in mm.",
            code="row-not-numbers",
        )
    return numbers
