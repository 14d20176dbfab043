"""Bodies without an obstacle: Newton's method and continuation under displacements and dead loads."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.material import Material
from palpate.mechanics import (
    Continuation,
    DeadLoad,
    DeadLoading,
    Equilibrium,
    NullMonitor,
    Problem,
    Solid,
    SolverSpec,
    State,
    System,
    make_linear_solver,
)
from palpate.verify.mapped import Grid

TOLERANCE = 1e-8
"""Maximum residual over mu and the square of a body's size. By hand."""
ITERATIONS = 40
"""Maximum Newton steps. By hand."""
LOAD_TOLERANCE = 1e-6
"""Maximum residual under dead loads over the maximum nodal load. By hand."""


def make_solid(grid: Grid, material: Material, fixed: BoolArray) -> Solid:
    """Make the solid of a grid; `fixed` (n, 3) marks prescribed components."""
    return Solid(grid.nodes, grid.cells, material, fixed)


def find_equilibrium(
    solid: Solid, displacement: FloatArray, tolerance: float | None = None, pressure: FloatArray | None = None
) -> Equilibrium:
    """Find the equilibrium of a solid near a displacement.

    Parameters
    ----------
    solid
        The solid.
    displacement
        (n, 3) mm; its prescribed components are kept.
    tolerance
        Maximum residual, N; by default `TOLERANCE` times mu and the square of the body's size.
    pressure
        (n_cells, 4) MPa; none without it.

    Raises
    ------
    PalpateError
        If Newton's method does not converge.
    """
    size = float(np.ptp(solid.nodes))
    tolerance = tolerance or TOLERANCE * solid.shear_modulus * size**2
    problem = Problem(solid, make_linear_solver(), tolerance, size)
    found = problem.solve(State(displacement, solid.rest().p if pressure is None else pressure), (), ITERATIONS)
    if not found.converged:
        raise PalpateError(
            f"No equilibrium was found: {found.outcome}, residual {found.residual:.3g} N after {found.iterations} "
            f"iterations is above {tolerance:.3g} N.",
            "Start nearer to it, or refine the mesh.",
            code="equilibrium-not-found",
        )
    return found


def reactions(solid: Solid, state: State) -> FloatArray:
    """Return the nodal forces (n, 3) N of a solid in a state; zero at free nodes in equilibrium."""
    system = System(np.zeros(len(solid.pattern.column)), np.zeros(solid.nodes.size))
    solid.assemble(state, system)
    return system.residual.reshape(-1, 3)


def follow_load(
    grid: Grid, material: Material, fixed: BoolArray, load: FloatArray, factors: FloatArray
) -> list[State]:
    """Follow a solid from rest under dead loads (n, 3) N; return the state at each of `factors` (k,).

    Raises
    ------
    PalpateError
        If the branch ends before the last factor.
    """
    solid = make_solid(grid, material, fixed)
    tolerance = LOAD_TOLERANCE * float(factors[0]) * float(np.abs(load).max())
    problem = Problem(solid, make_linear_solver(), tolerance, float(np.ptp(grid.nodes)))
    spec = SolverSpec(first_step=1.0, largest_step=1.0, iterations=ITERATIONS)
    path = Continuation(
        problem, DeadLoading(DeadLoad(load)), NullMonitor(), spec, unit=float(factors[-1]), jumps=False
    )
    states = []
    for factor in factors:
        if not path.advance(float(factor)):
            raise PalpateError(f"The load ended: {path.message}", "Refine the mesh.", code="path-ended")
        states.append(path.last.state)
    return states
