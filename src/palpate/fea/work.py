"""Work of a force over ascending or descending depths."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from palpate.core import FloatArray


def integrate_force(depth: FloatArray, force: FloatArray) -> FloatArray:
    """Return the integral (n,) mJ of a force (n,) N over monotonic depths (n,) mm, by a cubic spline."""
    if len(depth) <= 3:
        steps = 0.5 * (force[1:] + force[:-1]) * np.diff(depth)
        return np.concatenate([[0.0], np.cumsum(steps)])
    way = np.sign(depth[-1] - depth[0])
    whole = CubicSpline(way * depth, force).antiderivative()(way * depth)
    result: FloatArray = way * (whole - whole[0])
    return result
