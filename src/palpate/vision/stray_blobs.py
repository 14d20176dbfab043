"""Blobs outside a hexagonal lattice of markers: screws, arcs and glints of a rim."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from palpate.core import BoolArray, FloatArray, IntArray

_NEIGHBOURS, _HEXAGON = 7, 1.35
"""Number of neighbours; maximum distance of the sixth over that of the first in a hexagonal lattice.

It is 1 for a hexagon, 1.41 for a square. Corners of a pressed square field end too few lines.
"""
_OFF, _SIZE = 0.22, 1.4
"""Limits of a blob that continues the lattice: distance from a line, and ratio of diameters.

The distance is from the extrapolated line of two neighbours, over theirs.
"""
_LINES, _REGULAR, _LEAST, _LOOKED = 4, 0.8, 40, 60
"""Lines that an inner marker ends, and minimum share of such markers.

Then the minimum number of blobs, and the number of inner markers tested.
"""
_BEYOND, _WIDTH = 0.6, 2.5
"""Distance beyond the hull of a rejected blob, and width of the tested border, over the lattice step."""


def find_strays(points: FloatArray, diameters: FloatArray) -> BoolArray:
    """Return which blobs (n, 2), of diameters (n,), px, are outside a hexagonal lattice.

    They are beyond its hull, on fewer than two lines. All are inside if the field is not such a lattice, such as a
    square grid, rings or scattered markers.
    """
    none = np.zeros(len(points), bool)
    if len(points) < _LEAST:
        return none
    distance, near = cKDTree(points).query(points, _NEIGHBOURS + 1)
    if np.median(distance[:, 6] / np.maximum(distance[:, 1], 1e-9)) > _HEXAGON:
        return none
    step = float(np.median(distance[:, 1]))
    outer = _near_hull(points, points, _WIDTH * step)
    if outer is None:
        return none
    rows, inner = np.flatnonzero(outer), np.flatnonzero(~outer)
    on_line = np.ones(len(points), bool)
    if len(inner) < _LEAST // 2:
        return none
    inner = inner[:: max(len(inner) // _LOOKED, 1)]
    if np.mean(_count_lines(points, diameters, near, on_line, inner) >= _LINES) < _REGULAR:
        return none
    for _ in range(3):  # a blob off the lattice may stand on the line of another
        on_line[rows] = _count_lines(points, diameters, near, on_line, rows) >= 2
    beyond = _near_hull(points[on_line], points, -_BEYOND * step)
    return none if beyond is None else ~on_line & ~beyond


def _near_hull(points: FloatArray, places: FloatArray, margin: float) -> BoolArray | None:
    """Return whether places are within `margin` of a hull or outside; if negative, at most that far out."""
    try:
        equations = ConvexHull(points).equations
    except QhullError:
        return None
    out = (places @ equations[:, :2].T + equations[:, 2]).max(axis=1)
    return np.asarray(out > -margin if margin > 0.0 else out < -margin)


def _count_lines(
    points: FloatArray, diameters: FloatArray, near: IntArray, trusted: BoolArray, rows: IntArray
) -> IntArray:
    """Count the lines (k,) of three blobs that points (k,) end; the first two are trusted and similar."""
    first = near[rows, 1:]
    second = near[first][:, :, 1:]
    ends = 2.0 * points[first][:, :, None] - points[second]
    miss = np.linalg.norm(ends - points[rows, None, None], axis=-1)
    arm = np.linalg.norm(points[first] - points[rows, None], axis=-1)[:, :, None]
    fits = (miss < _OFF * arm) & trusted[first][:, :, None] & trusted[second]
    typical = np.sqrt(diameters[first][:, :, None] * diameters[second])
    ratio = diameters[rows, None, None] / np.maximum(typical, 1e-9)
    fits &= (ratio < _SIZE) & (ratio > 1.0 / _SIZE)
    return np.asarray(fits.any(axis=2).sum(axis=1))
