"""Bodies without a wall: the product's solid and Newton's method under prescribed displacements and dead loads."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.fea import (
    ContactLaw,
    ContactProblem,
    Equilibrium,
    OuterSurface,
    Plane,
    Solid,
    State,
    System,
    make_linear_solver,
    untouched,
)
from palpate.material import Material
from palpate.verify.mapped import Grid

NO_WALL = Plane(normal=np.array([0.0, 0.0, 1.0]), point=np.array([0.0, 0.0, 1e9]))
NO_CONTACT = ContactLaw(stiffness=1.0, width=1.0, tangential_stiffness=1.0, friction=0.0)
TOLERANCE = 1e-8
"""Greatest residual over mu and the square of a body's size."""
ITERATIONS = 40
LOAD_TOLERANCE = 1e-6
"""Greatest residual under dead loads over the greatest nodal load."""


class LoadedSolid(Solid):
    """A solid under dead loads: forces (n, 3) N that keep their direction, of the potential ``-f·u``."""

    load: FloatArray

    def assemble(self, state: State, system: System) -> float:
        energy = super().assemble(state, system)
        system.residual[:] -= self.load.ravel()
        return energy


def make_solid(grid: Grid, material: Material, fixed: BoolArray, load: FloatArray | None = None) -> Solid:
    """Make the solid of a grid; `fixed` (n, 3) marks prescribed components, `load` (n, 3) N are dead loads."""
    if load is None:
        return Solid(grid.nodes, grid.cells, material, fixed)
    solid = LoadedSolid(grid.nodes, grid.cells, material, fixed)
    solid.load = load
    return solid


def find_equilibrium(
    solid: Solid, displacement: FloatArray, tolerance: float | None = None, pressure: FloatArray | None = None
) -> Equilibrium:
    """Find the equilibrium of a solid near a displacement.

    Parameters
    ----------
    solid
        The solid.
    displacement
        (n, 3) mm; its prescribed components stand.
    tolerance
        Greatest residual, N; without it, `TOLERANCE` times mu and the square of the body's size.
    pressure
        (n_cells, 4) MPa; none without it.

    Raises
    ------
    PalpateError
        If Newton's method does not converge.
    """
    size = float(np.ptp(solid.nodes))
    tolerance = tolerance or TOLERANCE * solid.material.law.shear_modulus * size**2
    surface = OuterSurface(solid.nodes, np.empty((0, 9), np.int64), np.empty(0, np.int64))
    problem = ContactProblem(solid, surface, NO_CONTACT, make_linear_solver(), tolerance, size)
    start = State(displacement, solid.rest().p if pressure is None else pressure)
    found = problem.solve(start, NO_WALL, untouched(0), ITERATIONS)
    if not found.converged:
        raise PalpateError(
            f"No equilibrium was found: {found.outcome}, residual {found.residual:.3g} N after {found.iterations} "
            f"iterations is above {tolerance:.3g} N.",
            "Start nearer to it, or refine the mesh.",
        )
    return found


def reactions(solid: Solid, state: State) -> FloatArray:
    """Forces (n, 3) N that hold the nodes of a solid in a state; zero at free ones in equilibrium."""
    system = System(np.zeros(len(solid.pattern.column)), np.zeros(solid.nodes.size))
    solid.assemble(state, system)
    return system.residual.reshape(-1, 3)


def follow_load(
    grid: Grid, material: Material, fixed: BoolArray, load: FloatArray, factors: FloatArray
) -> list[State]:
    """Follow a solid from rest under growing dead loads.

    Parameters
    ----------
    grid, material, fixed, load
        As in `make_solid`; prescribed displacements are zero.
    factors
        (k,) growing factors on the load.

    Returns
    -------
    list
        The state at every factor, each started from the last three.
    """
    at, states = [0.0], [State(np.zeros_like(grid.nodes), np.zeros((len(grid.cells), 4)))]
    for factor in factors:
        solid = make_solid(grid, material, fixed, factor * load)
        start = extrapolate(at[-3:], states[-3:], factor)
        tolerance = LOAD_TOLERANCE * factor * float(np.abs(load).max())
        states.append(find_equilibrium(solid, start.u, tolerance, start.p).state)
        at.append(float(factor))
    return states[1:]


def extrapolate(at: list[float], states: list[State], to: float) -> State:
    """Carry states, known at parameters `at` (load or depth in mm), by a polynomial to another parameter."""
    u, p = np.zeros_like(states[0].u), np.zeros_like(states[0].p)
    for k, state in enumerate(states):
        others = np.delete(np.array(at), k)
        share = float(np.prod((to - others) / (at[k] - others)))
        u, p = u + share * state.u, p + share * state.p
    return State(u, p)
