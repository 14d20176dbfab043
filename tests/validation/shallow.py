"""Shallow-shell theory of a free spherical cap turned inside out: the smallest cap that stays so.

Axisymmetric equations of Marguerre and Reissner, as ordinary differential equations for the slope and the stress
function, solved by collocation; nothing is shared with the solid. With ``r = a x``, slope ``(a/R) y`` (``y = -x`` at
rest) and ``r N_r = (D/a) f``:

``x y'' + y' - y/x = f y``, ``x f'' + f' - f/x = -(lambda⁴/2) (y² - x²)``,

``f(1) = 0`` and ``(y + x)' + nu (y + x) = 0`` at the free rim, ``lambda⁴ = 12 (1 - nu²) a⁴ / (R h)²``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_bvp

from palpate.core import FloatArray, PalpateError

_NEAR_AXIS, _POINTS = 1e-3, 200
_TOLERANCE, _NODES = 1e-6, 20_000
_DEEP, _STEP = 8.0, 0.1
"""Lambda at which a mirrored cap is sure to stay, and the steps down from there."""
_FINE, _MOST = 4, 80
"""Steps of the rim's slope near the fold, a step of lambda's change being cut in so many; and most of them."""


@dataclass(frozen=True)
class _Solution:
    """Slope, stress function and their derivatives (4, n) at x (n,), and lambda."""

    x: FloatArray
    values: FloatArray
    rise: float


def threshold(poisson: float) -> float:
    """The least lambda of a free cap that stays inside out.

    Inverted caps are followed down in lambda, then by the slope of the rim past the fold; the least lambda is that of
    a parabola through the lowest three.

    Parameters
    ----------
    poisson
        Poisson's ratio.

    Raises
    ------
    PalpateError
        If no fold is found.
    """
    here = _inverted(poisson, _DEEP, None)
    if here is None:
        raise PalpateError("No inverted cap was found.", "Start at a larger lambda.", code="inverted-cap-missing")
    before = here
    while (found := _inverted(poisson, here.rise - _STEP, here)) is not None:
        before, here = here, found
    slope, change = here.values[0, -1], (here.values[0, -1] - before.values[0, -1]) / _FINE
    near = [here.rise]
    for step in range(1, _MOST):
        here = _with_rim_slope(poisson, slope + step * change, here)
        near.append(here.rise)
        if step > 1 and near[-1] > near[-2]:
            a, b, c = near[-3:]
            return b - (c - a) ** 2 / (8 * (a - 2 * b + c))
    raise PalpateError(
        f"No fold was found down to lambda = {min(near):.4g}.", "Take more steps.", code="fold-missing"
    )


def _inverted(poisson: float, rise: float, start: _Solution | None) -> _Solution | None:
    """The inverted cap of a lambda, from that of another or from the mirrored one; `None` where there is none."""
    x = np.linspace(_NEAR_AXIS, 1.0, _POINTS) if start is None else start.x
    mirrored = np.vstack([x - 1.2 * x**20, 1 - 24 * x**19, 0 * x, 0 * x])
    found = solve_bvp(
        lambda x, z: _slopes(x, z, rise),
        lambda a, b: _ends(a, b, poisson),
        x,
        mirrored if start is None else start.values,
        tol=_TOLERANCE,
        max_nodes=_NODES,
    )
    if not found.success or found.y[1, 0] < 0:
        return None
    return _Solution(found.x, found.y, rise)


def _with_rim_slope(poisson: float, slope: float, start: _Solution) -> _Solution:
    """The inverted cap whose rim has a slope, whatever its lambda."""
    found = solve_bvp(
        lambda x, z, p: _slopes(x, z, p[0]),
        lambda a, b, p: np.append(_ends(a, b, poisson), b[0] - slope),
        start.x,
        start.values,
        p=np.array([start.rise]),
        tol=_TOLERANCE,
        max_nodes=_NODES,
    )
    if not found.success:
        raise PalpateError(
            f"No inverted cap with a rim's slope of {slope:.3g} was found.",
            "Take shorter steps.",
            code="inverted-cap-missing",
        )
    return _Solution(found.x, found.y, float(found.p[0]))


def _slopes(x: FloatArray, z: FloatArray, rise: float) -> FloatArray:
    y, dy, f, df = z
    stretch = -(rise**4 / 2) * (y**2 - x**2) / x
    return np.vstack([dy, f * y / x - dy / x + y / x**2, df, stretch - df / x + f / x**2])


def _ends(a: FloatArray, b: FloatArray, poisson: float) -> FloatArray:
    """Regular at the axis; no force and no moment at the rim."""
    return np.array(
        [a[0] - _NEAR_AXIS * a[1], a[2] - _NEAR_AXIS * a[3], b[2], b[1] + 1 + poisson * (b[0] + 1)],
    )
