"""Cubic splines over a rectangular grid of three axes, with partial derivatives, compiled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from palpate.core import FloatArray, kernel

DEGREE = 3
"""Degree of the splines. By hand."""
BEYOND = 0.25
"""Extrapolation range of a spline, over the last distance of its knots. By hand."""


@dataclass(frozen=True, eq=False)
class TensorSpline:
    """Many values as cubic splines over three axes.

    Attributes
    ----------
    knots
        Knots of each axis; those of the first axis are double, as value and slope are fitted.
    coefficients
        (2 n_0, n_1, n_2, m) B-spline coefficients of the m values; four if n_0 is 1.
    """

    knots: tuple[FloatArray, FloatArray, FloatArray]
    coefficients: FloatArray

    def evaluate(self, at: FloatArray) -> FloatArray:
        """Values and partial derivatives (4, m) at a point (3,), which is limited to just beyond the grid."""
        found = np.empty((4, self.coefficients.shape[-1]))
        _evaluate(self.knots, self.coefficients, np.asarray(at, float), found)
        return found


def fit_spline(
    axes: tuple[FloatArray, FloatArray, FloatArray], values: FloatArray, slopes: FloatArray | None = None
) -> TensorSpline:
    """Fit a spline through values (n_0, n_1, n_2, m) over the ascending places (n_i,) of each axis.

    The second and third axis need four places; of the first, three give a parabola, and one a constant. `slopes`
    (n_0, n_1, n_2, m) are derivatives of the values by the first axis, which the spline has too (Hermite), nan where
    unknown: then those of the spline without slopes, or at the first place that of the parabola with the next slope.
    """
    places, found, later = axes[0], np.asarray(values, float), axes[1:]
    if len(places) > 1:
        step = np.diff(places)[:, None, None, None]
        smooth = make_interp_spline(places, found, k=min(DEGREE, len(places) - 1)).derivative()(places)
        given = np.full_like(found, np.nan) if slopes is None else slopes
        rates = np.where(np.isfinite(given), given, smooth)
        first = 2.0 * (found[1] - found[0]) / step[0] - given[1]
        rates[0] = np.where(np.isfinite(given[0]) | ~np.isfinite(first), rates[0], first)
        left = found - rates * np.concatenate([0.0 * step[:1], step]) / DEGREE
        right = found + rates * np.concatenate([step, 0.0 * step[:1]]) / DEGREE
        found = np.stack([left, right], axis=1).reshape(-1, *found.shape[1:])
        knots = [np.repeat(places, [DEGREE + 1, *[2] * (len(places) - 2), DEGREE + 1])]
    else:
        knots = [np.repeat(places[0] + np.array([-1.0, 1.0]), DEGREE + 1)]
        found = np.repeat(found, DEGREE + 1, axis=0)
    for axis, places in enumerate(later, start=1):
        spline = make_interp_spline(places, found, k=DEGREE, axis=axis)
        knots.append(np.asarray(spline.t, float))
        found = np.moveaxis(spline.c, 0, axis)
    return TensorSpline((knots[0], knots[1], knots[2]), np.ascontiguousarray(found))


@kernel
def _basis(knots: FloatArray, x: float, value: FloatArray, slope: FloatArray) -> int:
    """Write the four nonzero cubic B-splines (4,) at x and their slopes; return the index of the first."""
    last = len(knots) - DEGREE - 2
    beyond = BEYOND * (knots[last + 1] - knots[last])
    x = min(max(x, knots[DEGREE]), knots[last + 1] + beyond)
    span = DEGREE
    while span < last and x >= knots[span + 1]:
        span += 1
    value[0] = 1.0
    for degree in range(1, DEGREE + 1):
        if degree == DEGREE:  # the quadratics give the slopes of the cubics
            slope[:] = 0.0
            for k in range(degree):
                width = knots[span + k + 1] - knots[span + k + 1 - degree]
                slope[k] -= degree * value[k] / width
                slope[k + 1] += degree * value[k] / width
        saved = 0.0
        for k in range(degree):
            right, left = knots[span + k + 1] - x, x - knots[span + k + 1 - degree]
            share = value[k] / (right + left)
            value[k] = saved + right * share
            saved = left * share
        value[degree] = saved
    return span - DEGREE


@kernel
def _evaluate(
    knots: tuple[FloatArray, FloatArray, FloatArray], coefficients: FloatArray, at: FloatArray, found: FloatArray
) -> None:
    """Write values and partial derivatives (4, m) at a point (3,)."""
    first = np.empty(3, np.int64)
    value, slope = np.empty((3, 4)), np.empty((3, 4))
    first[0] = _basis(knots[0], at[0], value[0], slope[0])
    first[1] = _basis(knots[1], at[1], value[1], slope[1])
    first[2] = _basis(knots[2], at[2], value[2], slope[2])
    found[:, :] = 0.0
    m = coefficients.shape[3]
    for i in range(4):
        for j in range(4):
            for k in range(4):
                w0 = value[0, i] * value[1, j] * value[2, k]
                w1 = slope[0, i] * value[1, j] * value[2, k]
                w2 = value[0, i] * slope[1, j] * value[2, k]
                w3 = value[0, i] * value[1, j] * slope[2, k]
                row = coefficients[first[0] + i, first[1] + j, first[2] + k]
                for n in range(m):
                    c = row[n]
                    found[0, n] += w0 * c
                    found[1, n] += w1 * c
                    found[2, n] += w2 * c
                    found[3, n] += w3 * c
