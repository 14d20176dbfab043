"""The smallest free spherical cap that stays inside out, shallow and deep.

Taffetani, Jiang, Holmes & Vella (*Proc. R. Soc. A* 474, 20170910, 2018, arXiv 1804.04219) measured and computed when
a cap has a second state, and found shallow-shell theory, modified, to foretell it even for rather deep caps. Their
points are in figures; so ours are held to the theory itself (`shallow`), with ``lambda = (12 (1 - nu²))^(1/4) alpha
sqrt(R/h)`` formed with the angle alpha from axis to rim, whose base radius over R it is where a cap is shallow. A
cap is pushed down at its apex, its rim on a slippery support, past both limit points: it has a second state where
the load in the valley is negative. The thickness at which that load is zero is found by the secant method; at zero
load neither the support nor the way of pushing matters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray
from palpate.mechanics import Problem, Solid, make_linear_solver
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import Grid, Turn, even
from validation.arc_length import ArcLength
from validation.curves import highest
from validation.shallow import threshold
from validation.walls import elastic, load_top, middle_rim, round_wall

_RADIUS, _CELLS = 100.0, 12
_SHALLOW, _DEEP = 0.2, (0.5, 0.8, 1.1)
"""Angles from axis to rim, radians."""
_LAYERS = {1.1: 2}
"""Cells through the wall, where it is thick: h/R is 0.11 at 1.1 rad."""
_BRACKET = (0.97, 1.05)
"""First two lambdas over that of the theory."""
_SECANTS, _RESIDUAL = 2, 1e-4
_FIRST, _LONGEST = 0.02, 0.06
"""Increments over the rise of the cap."""
_CLOSE, _NEAR = 5e-3, 1.5e-2
"""Tolerance of shallow and of deep caps."""
_BEYOND = 1.1


@dataclass(frozen=True)
class Everted:
    """A cap pushed through.

    Attributes
    ----------
    angle
        From the axis to the rim, radians.
    rise
        Lambda, formed with the angle.
    poisson
        Poisson's ratio.
    thicker
        Factor on the thickness that follows from lambda; 1 but for a control.
    """

    angle: float
    rise: float
    poisson: float
    thicker: float = 1.0

    @property
    def thickness(self) -> float:
        """Of the wall, in units of `_RADIUS` = 100."""
        slender = self.angle**2 * np.sqrt(12 * (1 - self.poisson**2)) / self.rise**2
        return float(_RADIUS * slender * self.thicker)

    def path(self) -> ArcLength:
        """The path under a load at the apex, from rest."""
        grid = self._grid()
        solid = self._solid(grid)
        force = load_top(solid, self.angle / _CELLS) * self.thickness**3 / _RADIUS**2
        tolerance = _RESIDUAL * float(np.abs(force).max())
        height = _RADIUS * (1 - np.cos(self.angle))
        problem = Problem(solid, make_linear_solver(), tolerance, self.thickness)
        return ArcLength(problem, force, _FIRST * height, _LONGEST * height)

    def _grid(self) -> Grid:
        cuts = self.angle * even(_CELLS)
        return round_wall(_RADIUS, self.thickness, cuts, Turn(1), _LAYERS.get(self.angle, 1))

    def _solid(self, grid: Grid) -> Solid:
        rim = middle_rim(grid, _RADIUS, self.thickness, self.angle)
        return make_solid(
            grid, elastic(1.0, self.poisson), np.stack([grid.near(0, 0.0), grid.near(1, 0.0), rim], axis=-1)
        )


def valley(cap: Everted) -> tuple[float, ArcLength]:
    """Load in the valley over that on the peak, and the path up to just behind the valley."""
    path = cap.path()
    load = [0.0]
    while len(load) < 4 or not (min(np.diff(load)) < 0 and load[-1] > load[-2]):
        load.append(path.advance().factor)
    return highest(np.array(load[-3:])) / max(load), path


def smallest(angle: float, poisson: float, theory: float, thicker: float = 1.0) -> float:
    """The lambda at which the load in the valley is zero, by secants from near that of the theory."""
    rises = [share * theory for share in _BRACKET]
    loads = [valley(Everted(angle, rise, poisson, thicker))[0] for rise in rises]
    for step in range(_SECANTS + 1):
        slope = (loads[-1] - loads[-2]) / (rises[-1] - rises[-2])
        rises.append(rises[-1] - loads[-1] / slope)
        if step < _SECANTS:
            loads.append(valley(Everted(angle, rises[-1], poisson, thicker))[0])
    return float(rises[-1])


def bistable_cap(thicker: float = 1.0) -> list[Row]:
    """Thresholds of shallow and deep caps, and whether the second state is stable beyond.

    Parameters
    ----------
    thicker
        Factor on the thickness of ours; 1 but for a control that must not pass.
    """
    theory = {poisson: threshold(poisson) for poisson in (0.3, 0.5)}
    shallow = [smallest(_SHALLOW, poisson, value, thicker) for poisson, value in theory.items()]
    deep = [smallest(angle, 0.5, theory[0.5], thicker) for angle in _DEEP]
    unstable = [_unstable_beyond(angle, theory[0.5]) for angle in (_SHALLOW, _DEEP[-1])]
    at = [f"{angle:g} rad" for angle in (_SHALLOW, *_DEEP)]
    return [
        compare(
            "lambda from which a shallow cap stays, 0.2 rad",
            shallow,
            np.array(list(theory.values())),
            _CLOSE,
            [f"nu = {poisson:g}" for poisson in theory],
        ),
        compare(
            "lambda from which a deep cap stays, nu = 0.5, to the shallow theory's",
            deep,
            _same(deep, theory[0.5]),
            _NEAR,
            at[1:],
        ),
        compare("unstable modes of the second state, lambda 10 % beyond", unstable, [0, 0], 0.0, [at[0], at[-1]]),
    ]


def _same(values: list[float], value: float) -> FloatArray:
    return np.full(len(values), value)


def _unstable_beyond(angle: float, theory: float) -> int:
    """Unstable modes, symmetric to two planes, of the unloaded second state."""
    _, path = valley(Everted(angle, _BEYOND * theory, 0.5))
    while path.points[-1].factor < 0:
        path.advance()
    return path.points[-1].negative_pivots
