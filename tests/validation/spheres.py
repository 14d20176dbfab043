"""A complete thin sphere under outside pressure and under a force at its pole, and a hemisphere held at its rim.

*Sphere*: it buckles at ``p0 = 2 E h² / (R² sqrt(3 (1 - nu²)))`` (Zoelly 1915; Timoshenko & Gere, *Theory of Elastic
Stability*, 1961), the limit of thin walls under a pressure that turns with the wall; ours keeps its direction, and a
wall is a solid, either of which is stiffer by the order of h/R. *Hemisphere* clamped at the equator: it buckles at
its edge, at 0.8 p0 by finite elements (Ubamanyu et al. 2024, arXiv 2412.15066, abstract). *Force*: ``F = 4 E h² w /
(R sqrt(3 (1 - nu²)))`` (Reissner 1946, *J. Math. Phys.* 25, 80), spread over a disc of radius h. An eighth of the
sphere is solved, so that modes are even about each axis.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate.mechanics import Problem, make_linear_solver
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import follow_load, make_solid
from palpate.verify.mapped import Turn, even
from validation.arc_length import ArcLength
from validation.graded import graded
from validation.walls import elastic, load_top, press_round, round_wall

_POISSON = 0.3
_SPHERES = {20.0: (16, 8), 40.0: (24, 12), 80.0: (30, 15)}
"""R/h, and cells from pole to equator and in an eighth of a turn."""
_HEMISPHERE, _HEMISPHERE_CELLS = 50.0, (22, 9)
_PRINTED, _ROUNDING = 0.8, 0.05
_STEP, _EXACT = 0.15, 5e-4
"""First increment and the last before symmetry is lost, over the thickness."""
_RESIDUAL, _THIN = 1e-6, 1e-2
_POINTED = (50.0, 100.0, 200.0)
_FINE, _RINGS, _LIGHT = 2, 30, 2e-3
"""Cells within a thickness of the pole, all from pole to equator, and the deflection over h that the force is for."""


def classical_pressure(ratio: float) -> float:
    """Buckling pressure over E of a thin sphere of R/h = `ratio`."""
    return float(2 / ratio**2 / np.sqrt(3 * (1 - _POISSON**2)))


def buckling(ratio: float, cells: tuple[int, int], *, clamped: bool) -> float:
    """Pressure over E at which a sphere, or a hemisphere held at its rim, leaves its symmetry; its R/h and cells."""
    grid = round_wall(ratio, 1.0, 0.5 * np.pi * even(cells[0]), Turn(cells[1]))
    equator = grid.near(2, 0.0)
    fixed = np.stack([grid.near(0, 0.0), grid.near(1, 0.0), equator], axis=-1)
    fixed[equator] |= clamped
    solid = make_solid(grid, elastic(1.0, _POISSON), fixed)
    force = press_round(solid, 1.0) * classical_pressure(ratio)
    problem = Problem(solid, make_linear_solver(), _RESIDUAL * float(np.abs(force).max()), 1.0)
    path = ArcLength(problem, force, _STEP, _STEP)
    while path.points[-1].negative_pivots == 0 or path.step > _EXACT:
        if path.points[-1].negative_pivots > 0:
            path.go_back(path.step / 4)
        path.longest = path.step
        path.advance()
    return path.points[-1].factor * classical_pressure(ratio)


def complete_spheres(ratios: Sequence[float], thicker: float = 1.0) -> list[Row]:
    """Compare buckling pressures of spheres of several R/h with the classical one, and their limit of thin walls.

    Parameters
    ----------
    ratios
        R/h, keys of `_SPHERES`.
    thicker
        Factor on the thickness of ours; 1 but for a control that must not pass.
    """
    share = [
        buckling(ratio / thicker, _SPHERES[ratio], clamped=False) / classical_pressure(ratio) for ratio in ratios
    ]
    limit = np.polyfit(1 / np.array(ratios), share, 1)[1]
    return [
        *(
            compare(f"pressure over p0, R/h = {ratio:g}", value, 1.0, _THIN + 1 / ratio)
            for ratio, value in zip(ratios, share, strict=True)
        ),
        compare("pressure over p0, carried to h/R = 0", limit, 1.0, _THIN),
    ]


def sphere_buckling() -> list[Row]:
    """Compare the buckling pressures of complete spheres, and that of a clamped hemisphere, with published ones."""
    rim = buckling(_HEMISPHERE, _HEMISPHERE_CELLS, clamped=True) / classical_pressure(_HEMISPHERE)
    return [
        *complete_spheres(list(_SPHERES)),
        compare("clamped hemisphere, pressure over p0", rim, _PRINTED, _ROUNDING, scale=1.0),
    ]


def pole_stiffness(ratio: float, thicker: float = 1.0) -> float:
    """Stiffness at the pole of a sphere over Reissner's."""
    stiffness = 4 / ratio / np.sqrt(3 * (1 - _POISSON**2))
    cuts = 0.5 * np.pi * graded(1 / (_FINE * ratio * 0.5 * np.pi), _FINE, _RINGS)
    grid = round_wall(ratio, thicker, cuts, Turn(1))
    fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
    material = elastic(1.0, _POISSON)
    force = load_top(make_solid(grid, material, fixed), float(cuts[_FINE]))
    load = _LIGHT * stiffness
    state = follow_load(grid, material, fixed, force, np.array([load]))[0]
    return load / (4 * float((force * state.u).sum())) / float(stiffness)


def sphere_point(thicker: float = 1.0) -> list[Row]:
    """Stiffness under a force at the pole, over Reissner's, for three R/h; `thicker` is a factor, for a control."""
    share = np.array([pole_stiffness(ratio, thicker) for ratio in _POINTED])
    slender = 1 / np.array(_POINTED)
    at = [f"R/h = {ratio:g}" for ratio in _POINTED]
    limit = np.polyfit(slender, share, 1)[1]
    return [
        compare("stiffness at the pole over Reissner's", share, np.ones(len(share)), 2e-2, at),
        compare("stiffness over Reissner's, carried to h/R = 0", limit, 1.0, _THIN),
    ]
