"""Growth of an assignment from one marker to its neighbours, for designs and unknown layouts.

Every assigned blob has a local linear map of its surroundings, fitted to its assigned neighbours and regularised
towards the map of the blob from which it was reached. A neighbour is predicted by the maps of all assigned blobs
around it, and assigned to the nearest blob if that is near enough and free. The assignment can thus follow
displacements of many spacings that change slowly from blob to blob.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray, IntArray, kernel


def mutual_nearest(places: FloatArray, blobs: cKDTree, reach: FloatArray) -> IntArray:
    """Return the blobs (m,) that are mutual nearest neighbours of places (m, 2) within reach; else -1."""
    far, blob = blobs.query(places)
    _, back = cKDTree(places).query(blobs.data)
    return np.where((back[blob] == np.arange(len(places))) & (far < reach), blob, -1)


def spread_starts(places: FloatArray, usable: BoolArray, inner: float, count: int) -> list[int]:
    """Return places to grow from: the most central usable place, then the most distant ones.

    At most `count` of the usable (m,) places (m, 2) px are chosen, at most `inner` of the outermost distance from the
    centre.
    """
    far = np.linalg.norm(places - places.mean(axis=0), axis=1)
    usable = usable & (far <= inner * far.max())
    chosen = [int(np.argmin(np.where(usable, far, np.inf)))]
    while len(chosen) < min(count, int(usable.sum())):
        apart = np.linalg.norm(places[:, None] - places[chosen], axis=-1).min(axis=1)
        chosen.append(int(np.argmax(np.where(usable, apart, -1.0))))
    return chosen


def grow_largest(
    starts: Iterable[tuple[FloatArray, IntArray]], near: IntArray, blobs: FloatArray, tolerance: float, least: float
) -> list[IntArray]:
    """Grow assignments (m,) from several starts; return the different ones, the largest first.

    A start is (m, 2) places at rest, px, and (m,) an initial assignment. Assignments of too few markers are dropped.
    For the further arguments see `grow_assignment`.
    """
    grown: dict[bytes, IntArray] = {}
    for rest, start in starts:
        match = grow_assignment(rest, near, blobs, start, tolerance)
        if (match >= 0).sum() >= least * len(rest):
            grown.setdefault(match.tobytes(), match)
    return sorted(grown.values(), key=lambda match: -int((match >= 0).sum()))


@kernel
def grow_assignment(
    rest: FloatArray,
    near: IntArray,
    dots: FloatArray,
    start: IntArray,
    tolerance: float,
) -> IntArray:
    """Grow an assignment (m,) of image blobs to markers from a start (m,); -1 means unassigned.

    Markers have places (m, 2) at rest, px, and neighbours (m, k), filled with -1. A blob (n, 2) is at most the
    tolerance from its predicted place, over the distance to the predicting neighbour.
    """
    count, seen = len(rest), len(dots)
    match = start.copy()
    owner = np.full(seen, -1)
    maps = np.zeros((count, 4))
    maps[:, 0] = maps[:, 3] = 1.0
    front = match >= 0
    for dot in range(count):
        if match[dot] >= 0:
            owner[match[dot]] = dot
            _fit_map(rest, near, dots, match, maps, dot, 0.3)
    for _ in range(count):
        tried = np.zeros(count, np.bool_)
        grown = np.zeros(count, np.bool_)
        taken = 0
        for parent in range(count):
            if not front[parent]:
                continue
            for k in range(near.shape[1]):
                dot = near[parent, k]
                if dot < 0 or match[dot] >= 0 or tried[dot]:
                    continue
                tried[dot] = True
                found = _look(rest, near, dots, match, maps, dot, tolerance, owner)
                if found >= 0:
                    match[dot] = found
                    owner[found] = dot
                    for c in range(4):
                        maps[dot, c] = maps[parent, c]
                    grown[dot] = True
                    taken += 1
        if taken == 0:
            break
        for dot in range(count):
            if grown[dot] or front[dot]:
                _fit_map(rest, near, dots, match, maps, dot, 0.3)
        front = grown
    return match


@kernel
def assignment_residuals(rest: FloatArray, near: IntArray, dots: FloatArray, match: IntArray) -> FloatArray:
    """Return the distances (m,) of assigned blobs from predictions, over the distance to the neighbours.

    They are 0 if a marker or all of its neighbours have no blob. For the arguments see `grow_assignment`.
    """
    count = len(rest)
    maps = np.zeros((count, 4))
    maps[:, 0] = maps[:, 3] = 1.0
    off = np.zeros(count)
    for dot in range(count):
        if match[dot] >= 0:
            _fit_map(rest, near, dots, match, maps, dot, 0.05)
    for dot in range(count):
        if match[dot] < 0:
            continue
        x, y, _, mean, number = _expect(rest, near, dots, match, maps, dot)
        if number > 0:
            x, y = x - dots[match[dot], 0], y - dots[match[dot], 1]
            off[dot] = np.sqrt(x * x + y * y) / max(mean, 1e-9)
    return off


@kernel
def _look(
    rest: FloatArray,
    near: IntArray,
    dots: FloatArray,
    match: IntArray,
    maps: FloatArray,
    dot: int,
    tolerance: float,
    owner: IntArray,
) -> int:
    """Return the free blob nearest to the prediction of the neighbours; -1 if none is near enough."""
    x, y, least, _, number = _expect(rest, near, dots, match, maps, dot)
    if number == 0:  # a neighbour need not count its neighbour as one
        return -1
    best, far = -1, (tolerance * least) ** 2
    for j in range(len(dots)):
        square = (dots[j, 0] - x) ** 2 + (dots[j, 1] - y) ** 2
        if square < far:
            best, far = j, square
    return best if best >= 0 and owner[best] < 0 else -1


@kernel
def _expect(
    rest: FloatArray, near: IntArray, dots: FloatArray, match: IntArray, maps: FloatArray, dot: int
) -> tuple[float, float, float, float, int]:
    """Predict a blob by its assigned neighbours; return also their minimum and mean distance, and number."""
    x, y, least, length, number = 0.0, 0.0, 1e30, 0.0, 0
    for k in range(near.shape[1]):
        other = near[dot, k]
        if other < 0 or match[other] < 0:
            continue
        dx, dy = rest[dot, 0] - rest[other, 0], rest[dot, 1] - rest[other, 1]
        ax = maps[other, 0] * dx + maps[other, 1] * dy
        ay = maps[other, 2] * dx + maps[other, 3] * dy
        x += dots[match[other], 0] + ax
        y += dots[match[other], 1] + ay
        away = np.sqrt(ax * ax + ay * ay)
        least = min(least, away)
        length += away
        number += 1
    many = max(number, 1)
    return x / many, y / many, least, length / many, number


@kernel
def _fit_map(
    rest: FloatArray, near: IntArray, dots: FloatArray, match: IntArray, maps: FloatArray, dot: int, stiff: float
) -> None:
    """Fit a blob's local map to its assigned neighbours, regularised towards its current value."""
    sxx, sxy, syy = 0.0, 0.0, 0.0
    right = np.zeros(4)
    for k in range(near.shape[1]):
        other = near[dot, k]
        if other < 0 or match[other] < 0:
            continue
        dx, dy = rest[other, 0] - rest[dot, 0], rest[other, 1] - rest[dot, 1]
        ux = dots[match[other], 0] - dots[match[dot], 0]
        uy = dots[match[other], 1] - dots[match[dot], 1]
        sxx += dx * dx
        sxy += dx * dy
        syy += dy * dy
        right[0] += ux * dx
        right[1] += ux * dy
        right[2] += uy * dx
        right[3] += uy * dy
    hold = stiff * (sxx + syy) / 2.0 + 1e-9
    sxx += hold
    syy += hold
    for c in range(4):
        right[c] += hold * maps[dot, c]
    det = sxx * syy - sxy * sxy
    maps[dot, 0] = (right[0] * syy - right[1] * sxy) / det
    maps[dot, 1] = (right[1] * sxx - right[0] * sxy) / det
    maps[dot, 2] = (right[2] * syy - right[3] * sxy) / det
    maps[dot, 3] = (right[3] * sxx - right[2] * sxy) / det
