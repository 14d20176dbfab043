"""Properties of a correct discretisation: patch tests, rigid motions, modes, tangent, convergence."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.material import get_material
from palpate.mechanics import Solid, State, System, cauchy_stress
from palpate.verify.bending import SPAN, make_block, solve_bending
from palpate.verify.case import Row, below, compare
from palpate.verify.equilibrium import find_equilibrium, make_solid
from palpate.verify.mapped import Grid, even, join, map_block
from palpate.verify.pressing import Pressing
from palpate.verify.rubber import YEOH

SILICONE = get_material("zaid_2024_ecoflex_00_30")
"""Silicone of the paper, K/mu = 2000."""
_NOISE = 0.04
"""Random displacement of the nodes of a distorted mesh over the size of its cells. By hand."""


def distorted_cube(cells: int, *, inside: bool) -> Grid:
    """Mesh a unit cube by `cells` along each side with random nodes; `inside`: surface nodes stay."""
    grid = join(map_block((even(cells),) * 3, lambda q: q))
    noise = _NOISE / cells * np.random.default_rng(3).normal(size=grid.nodes.shape)
    on_surface = _on_surface(grid)
    return Grid(np.where(on_surface[:, None] & inside, grid.nodes, grid.nodes + noise), grid.cells)


def _on_surface(grid: Grid) -> BoolArray:
    return np.any([grid.near(axis, value) for axis in range(3) for value in (0.0, 1.0)], axis=0)


def patch() -> list[Row]:
    """A distorted patch whose surface follows a finite homogeneous deformation does so inside."""
    grid = distorted_cube(3, inside=True)
    surface = _on_surface(grid)
    F = np.array([[1.3, 0.2, 0.0], [0.0, 0.9, 0.1], [0.1, 0.0, 0.85]])
    exact = grid.nodes @ (F - np.eye(3)).T
    solid = make_solid(grid, SILICONE, np.repeat(surface[:, None], 3, axis=1))
    start = exact + np.where(surface[:, None], 0.0, 0.01 * np.sin(9 * grid.nodes))
    state = find_equilibrium(solid, start, 1e-13 * SILICONE.bulk_modulus).state
    stress, J = cauchy_stress(solid, state), np.linalg.det(F)
    tau = SILICONE.evaluate(F[None])[1][0]
    expected = tau / J + SILICONE.bulk_modulus * (J - 1) * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    return [
        below("displacement over the patch's size", float(np.abs(state.u - exact).max()), 1e-10),
        below("stress over the maximum", float(np.abs(stress - expected).max() / np.abs(expected).max()), 1e-8),
    ]


def rigid_motion() -> list[Row]:
    """A turned and moved body has no energy and needs no force."""
    grid = distorted_cube(2, inside=False)
    solid = make_solid(grid, SILICONE, np.zeros(grid.nodes.shape, bool))
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    u = grid.nodes @ turn.T + [3.0, -2.0, 5.0] - grid.nodes
    energy, _, residual = _assemble(solid, State(u, solid.rest().p))
    return [
        below("maximum force over K L²", float(np.abs(residual).max()) / SILICONE.bulk_modulus, 1e-12),
        below("energy over K L³", abs(energy) / SILICONE.bulk_modulus, 1e-12),
    ]


def zero_energy_modes() -> list[Row]:
    """One free cell of any shape has the six rigid motions and no other mode without energy."""
    grid = distorted_cube(1, inside=False)
    solid = make_solid(grid, SILICONE, np.zeros(grid.nodes.shape, bool))
    values = np.linalg.eigvalsh(_assemble(solid, solid.rest())[1])
    return [compare("eigenvalues below 1e-9 of the largest one", np.sum(np.abs(values) < 1e-9 * values[-1]), 6, 0.0)]


def tangent() -> list[Row]:
    """Compare the condensed tangent with central differences of the residual, with condensed pressure."""
    grid = distorted_cube(1, inside=False)
    solid = make_solid(grid, SILICONE, np.zeros(grid.nodes.shape, bool))
    rng = np.random.default_rng(1)
    u, direction = 0.03 * rng.normal(size=grid.nodes.shape), rng.normal(size=grid.nodes.shape)
    state = State(u, 1e-3 * rng.normal(size=(1, 4)))
    _assemble(solid, state)
    state = state.moved(0 * u, solid.recover_pressure(0 * u))
    matrix = _assemble(solid, state)[1]
    still = solid.recover_pressure(0 * u)
    slope = np.zeros(u.size)
    for step, weight in ((1e-4, -1 / 3), (0.5e-4, 4 / 3)):
        _assemble(solid, state)
        dp = solid.recover_pressure(step * direction) - still
        ahead = _assemble(solid, state.moved(step * direction, dp))[2]
        behind = _assemble(solid, state.moved(step * direction, dp, -1.0))[2]
        slope += weight * (ahead - behind) / (2 * step)
    exact = matrix @ direction.ravel()
    error = np.abs(slope - exact).max() / np.abs(exact).max()
    return [below("error of the slope of the residual over it", float(error), 1e-7)]


def contact_patch() -> list[Row]:
    """A distorted block that a plane presses bears a uniform pressure."""
    grid = distorted_cube(3, inside=True)
    fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
    solid = make_solid(grid, SILICONE, fixed)
    penalty = 100 * SILICONE.young_modulus
    pressing = Pressing(solid, grid.outer_cells(grid.near(2, 1.0)), 1.0, (penalty, 1e-3), 1e-12, 1.0)
    found = pressing.follow([0.1, 0.2, 0.3])[-1]
    reach = pressing.reach(found)
    return [below("spread of the pressure over its mean", float(np.ptp(reach) / (reach.mean() - 5e-4)), 1e-8)]


def newton_rate() -> list[Row]:
    """Newton's method on a bent block: the residuals fall with the power 2."""
    grid = make_block(2, 4)
    fixed = np.repeat((grid.near(1, 0.0) | grid.near(1, SPAN / 2))[:, None], 3, axis=1)
    solid = make_solid(grid, YEOH.with_bulk_ratio(50.0), fixed)
    start = 0.1 * np.sin(grid.nodes[:, [1, 2, 0]] / 3) * ~fixed
    falls = np.diff(np.log(find_equilibrium(solid, start, 1e-13).history))
    return [compare("power of the last fall of the residual", falls[-1] / falls[-2], 2.0, 0.1, scale=1.0)]


def convergence_order() -> list[Row]:
    """Compare the energy of a block bent by 1 rad on meshes 1, 2 and 4 times as fine: order 4."""
    material = YEOH.with_bulk_ratio(1e3)
    energy = [solve_bending(make_block(n, 2 * n), material, 1.0, 18.10860461)[1] for n in (1, 2, 4, 8)]
    error = np.abs(np.diff(energy))
    orders = np.log2(error[:-1] / error[1:])
    return [compare("order of the energy", orders[-1], 4.0, 0.2, scale=1.0)]


def _assemble(solid: Solid, state: State) -> tuple[float, FloatArray, FloatArray]:
    """Energy (mJ), dense tangent (n, n) N/mm and residual (n,) N."""
    system = System(np.zeros(len(solid.pattern.column)), np.zeros(solid.nodes.size))
    energy = solid.assemble(state, system)
    upper = solid.pattern.matrix(system.data).toarray()
    return energy, upper + np.triu(upper, 1).T, system.residual
