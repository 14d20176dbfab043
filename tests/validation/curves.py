"""Curves of load over deflection: their limit points, and how far points are from them."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import FloatArray


def highest(three: FloatArray) -> float:
    """Top of the parabola through three values that are about evenly spaced."""
    before, middle, after = three
    bend = before - 2 * middle + after
    return float(middle - (after - before) ** 2 / (8 * bend))


def away_from(curve: FloatArray, points: FloatArray) -> FloatArray:
    """Distance (n,) of points (n, 2) from a curve (k, 2), each axis over the greatest of the points."""
    scale, along = points.max(axis=0), np.linspace(0, len(curve) - 1, 200 * len(curve))
    fine = np.column_stack([np.interp(along, np.arange(len(curve)), part) for part in curve.T]) / scale
    away, _ = cKDTree(fine).query(points / scale)
    return np.asarray(away)


def turns(curve: FloatArray) -> tuple[float, float]:
    """First greatest load of a curve (k, 2), and the least after it."""
    load = curve[:, 1]
    peak = int(np.argmax(np.diff(load) < 0))
    valley = peak + int(np.argmax(np.diff(load[peak:]) > 0))
    return highest(load[peak - 1 : peak + 2]), highest(load[valley - 1 : valley + 2])
