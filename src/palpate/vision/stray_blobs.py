"""Blobs outside a field of markers: screws, arcs and glints of a rim."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree

from palpate.core import BoolArray, FloatArray, IntArray

_NEIGHBOURS, _HEXAGON = 7, 1.35
"""Number of neighbours; maximum of the sixth distance over the first in a hexagonal lattice.

It is 1 for a hexagon, 1.41 for a square. Corners of a pressed square field end too few lines. By hand.
"""
_OFF, _SIZE, _OFF_STRICT, _SIZE_STRICT = 0.22, 1.4, 0.14, 1.25
"""Limits of a blob that continues the lattice: distance from a line, and ratio of diameters.

The distance is from the extrapolated line of two neighbours, over theirs. The strict limits are for corners of rows.
By hand.
"""
_LINES, _REGULAR, _LEAST, _LOOKED = 4, 0.8, 40, 60
"""Lines that an inner marker ends, and minimum share of such markers.

Then the minimum number of blobs, and the number of inner markers tested. By hand.
"""
_BEYOND, _WIDTH = 0.2, 2.3
"""Distance beyond the hull of a rejected blob, and width of the tested border.

Both are over the lattice step. By hand.
"""
_ROW, _GAP, _SLOPE = 5, (0.75, 1.4), 30.0
"""Minimum number of markers of a row along the border, limits of their distances, slope of a row.

The distances are over the lattice step, the slope is in degrees. By hand.
"""
_CORNER, _NEAR = 3, 1.3
"""Lines that end at a marker, or neighbours within `_NEAR` lattice steps.

So many keep a marker without a row, such as at a corner of the field. By hand.
"""
_ROWS, _UNEVEN, _STEEP, _MARKS = 0.7, 0.06, 0.15, 4
"""Limits of rows: share of markers near the border, median deviation of their gaps, median slope.

Gaps are over the lattice step. Rings and grids have slopes below 0.14, scattered markers and rings that the image
cuts slopes above 0.17. Then the maximum number of printed marks outside the field. By hand.
"""


def find_strays(points: FloatArray, diameters: FloatArray) -> BoolArray:
    """Return which blobs (n, 2), of diameters (n,), px, are outside the field of markers.

    Those outside a hexagonal lattice are on fewer than two of its lines. Those outside rows along the border of any
    field, such as the rings of a dome or the sides of a grid, are in no row themselves. All are inside if the border
    has no rows, such as of scattered markers. A single one is inside too, and up to four of the markers' size: they
    may be printed marks.
    """
    strays = np.zeros(len(points), bool)
    if len(points) < _LEAST:
        return strays
    try:
        strays = _find_outside_lattice(points, diameters)
        strays = strays | _find_outside_rows(points, diameters, ~strays)
    except QhullError:  # all blobs on one line
        pass
    ratio = diameters[strays] / np.median(diameters)
    alike = np.all((ratio < _SIZE_STRICT) & (ratio > 1.0 / _SIZE_STRICT))
    return np.zeros(len(points), bool) if strays.sum() <= (_MARKS if alike else 1) else strays


def _find_outside_lattice(points: FloatArray, diameters: FloatArray) -> BoolArray:
    """Return which blobs (n,) beyond a hexagonal lattice are on fewer than two of its lines."""
    none = np.zeros(len(points), bool)
    distance, near = cKDTree(points).query(points, _NEIGHBOURS + 1)
    if np.median(distance[:, 6] / np.maximum(distance[:, 1], 1e-9)) > _HEXAGON:
        return none
    step = float(np.median(distance[:, 1]))
    outer = _beyond_hull(points, points)[0] > -_WIDTH * step
    rows, inner = np.flatnonzero(outer), np.flatnonzero(~outer)
    on_line = ~none
    if len(inner) < _LEAST // 2:
        return none
    inner = inner[:: max(len(inner) // _LOOKED, 1)]
    if np.mean(_count_lines(points, diameters, near, on_line, inner) >= _LINES) < _REGULAR:
        return none
    for _ in range(3):  # a blob off the lattice may stand on the line of another
        on_line[rows] = _count_lines(points, diameters, near, on_line, rows) >= 2
    return ~on_line & (_beyond_hull(points[on_line], points)[0] > _BEYOND * step)


def _find_outside_rows(points: FloatArray, diameters: FloatArray, inside: BoolArray) -> BoolArray:
    """Return which blobs (n,) near the border of those inside stand in no row along it.

    A row is a chain of blobs of similar size at about one lattice step, nearly parallel to the border. Blobs without
    one leave, and the border is determined again, up to three times.
    """
    none = np.zeros(len(points), bool)
    near = cKDTree(points).query(points, _NEIGHBOURS + 1)[1]
    strict = _OFF_STRICT, _SIZE_STRICT
    spacing = float(np.median(np.linalg.norm(points[near[:, 1]] - points, axis=1)))
    rows = np.flatnonzero(inside & (_beyond_hull(points, points)[0] > -2.0 * _WIDTH * spacing))
    corner = np.zeros(len(points), bool)
    corner[rows] = _count_lines(points, diameters, near, inside, rows, strict) >= _CORNER
    for first in (True, False, False):
        numbers = np.flatnonzero(inside)
        distance, near = cKDTree(points[inside]).query(points[inside], _NEIGHBOURS + 2)
        near, own = numbers[near], np.full(len(points), np.nan)
        own[inside] = np.median(distance[:, 1:4], axis=1)
        step = float(np.median(own[inside]))
        outer = inside & (_beyond_hull(points[inside], points)[0] > -_WIDTH * step)
        if (inside & ~outer).sum() < _LEAST // 4:
            return none
        normal = _beyond_hull(points[inside & ~outer], points)[1]
        local = np.clip(np.median(own[near[:, 1:]], axis=1), 0.7 * step, 1.4 * step)
        own[inside] = local  # lattice step about each blob, px
        i, j = np.repeat(numbers, _NEIGHBOURS + 1), near[:, 1:].ravel()
        arm, apart = points[j] - points[i], distance[:, 1:].ravel()
        slope = np.minimum(np.abs(np.sum(arm * normal[i], axis=1)), np.abs(np.sum(arm * normal[j], axis=1)))
        gap, ratio = apart / np.minimum(own[i], own[j]), diameters[i] / np.maximum(diameters[j], 1e-9)
        alike = (ratio < _SIZE) & (ratio > 1.0 / _SIZE) & (_GAP[0] < gap)
        linked = alike & outer[i] & outer[j] & (slope < np.sin(np.radians(_SLOPE)) * apart) & (gap < _GAP[1])
        links = coo_array((np.ones(linked.sum()), (i[linked], j[linked])), shape=(len(points),) * 2)
        group = connected_components(links, directed=False)[1]
        near_by = np.bincount(i[alike & (gap < _NEAR)], minlength=len(points))
        good = (np.bincount(group)[group] >= _ROW) | (near_by >= _CORNER) | corner
        if first and not (linked.any() and good[outer].mean() >= _ROWS):
            return none
        uneven = np.median(np.abs(gap[linked] - np.median(gap[linked])))
        if first and (uneven > _UNEVEN or np.median(slope[linked] / apart[linked]) > _STEEP):
            return none
        still = inside & (~outer | good)
        if (still == inside).all():
            break
        inside = still
    return ~inside & (_beyond_hull(points[inside], points)[0] > _BEYOND * step)


def _beyond_hull(points: FloatArray, places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distances (n,) of places beyond the hull of points, and normals (n, 2) of its sides."""
    sides = ConvexHull(points).equations
    beyond = places @ sides[:, :2].T + sides[:, 2]
    return beyond.max(axis=1), sides[beyond.argmax(axis=1), :2]


def _count_lines(
    points: FloatArray,
    diameters: FloatArray,
    near: IntArray,
    trusted: BoolArray,
    rows: IntArray,
    limits: tuple[float, float] = (_OFF, _SIZE),
) -> IntArray:
    """Count lines (k,) of three blobs that points (k,) end; the first two are trusted and similar."""
    first = near[rows, 1:]
    second = near[first][:, :, 1:]
    ends = 2.0 * points[first][:, :, None] - points[second]
    miss = np.linalg.norm(ends - points[rows, None, None], axis=-1)
    arm = np.linalg.norm(points[first] - points[rows, None], axis=-1)[:, :, None]
    fits = (miss < limits[0] * arm) & trusted[first][:, :, None] & trusted[second]
    typical = np.sqrt(diameters[first][:, :, None] * diameters[second])
    ratio = diameters[rows, None, None] / np.maximum(typical, 1e-9)
    fits &= (ratio < limits[1]) & (ratio > 1.0 / limits[1])
    return np.asarray(fits.any(axis=2).sum(axis=1))
