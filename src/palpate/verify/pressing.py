"""Press a body from above by a rigid frictionless plane: the product's contact and Newton's method, step by step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.fea import (
    ContactLaw,
    ContactProblem,
    Damping,
    Equilibrium,
    OuterSurface,
    Plane,
    Solid,
    State,
    Touch,
    make_linear_solver,
    untouched,
)
from palpate.verify.equilibrium import extrapolate

DOWN = np.array([0.0, 0.0, 1.0])
"""Normal of the plane, away from the body below it."""
_ITERATIONS = 60
_MIDDLE, _HOLD = 0.5, 0.01
"""Share of the radius of contact that is held, and the spring over the contact stiffness."""
_RELAXATIONS, _FADED, _SLACK = 60, 1e-9, 1e3
"""Most pseudo-time steps, the viscosity over E/size² at which it has faded, and the slack on their tolerance."""
_SMALLEST = 1e-4
"""Smallest increment over the largest depth."""


@dataclass
class Pressing:
    """A body under a plane that comes down.

    Attributes
    ----------
    solid
        The body.
    outer
        (k,) cells whose face zeta = +1 may touch the plane.
    top
        Height of the plane at first touch, mm.
    penalty
        Contact stiffness, MPa/mm.
    width
        Width of its smooth start, mm.
    tolerance
        Greatest residual, N.
    size
        Greatest displacement of a Newton step, mm.
    held
        Whether the middle of the patch is held by a weak spring, as `palpate.fea` holds the flat branch of a dome.
    """

    solid: Solid
    outer: IntArray
    top: float
    penalty: float
    width: float
    tolerance: float
    size: float
    held: bool = False
    law: ContactLaw = field(init=False)
    problem: ContactProblem = field(init=False)
    touch: Touch = field(init=False)

    def __post_init__(self) -> None:
        nodes, faces = self.solid.nodes, self.solid.cells.nodes[self.outer][:, 18:27]
        surface = OuterSurface(nodes, faces, self.outer)
        self.law = ContactLaw(stiffness=self.penalty, width=self.width, tangential_stiffness=1.0, friction=0.0)
        linear = make_linear_solver()
        self.problem = ContactProblem(self.solid, surface, self.law, linear, self.tolerance, self.size)
        self.touch = untouched(len(surface.points))

    def plane(self, depth: float) -> Plane:
        """Plane at a depth in mm below first touch."""
        return Plane(normal=DOWN, point=np.array([0.0, 0.0, self.top - depth]))

    def solve(self, start: State, depth: float) -> Equilibrium:
        """Equilibrium near `start` under the plane at a depth, mm."""
        return self.problem.solve(start, self.plane(depth), self.touch, _ITERATIONS)

    def follow(self, depths: Sequence[float], start: tuple[float, State] | None = None) -> list[Equilibrium]:
        """Follow the equilibria to every depth.

        Parameters
        ----------
        depths
            mm, in the order in which they are visited.
        start
            Depth (mm) and state to start from; without it, rest at first touch.

        Raises
        ------
        PalpateError
            If no increment, however small, leads to the next depth.
        """
        first, state = start or (0.0, self.solid.rest())
        at, states = [first], [state]
        found = []
        for depth in depths:
            step = depth - at[-1]
            while abs(depth - at[-1]) > 1e-12:
                step = min(step, depth - at[-1], key=abs)
                here = self.solve(extrapolate(at[-3:], states[-3:], at[-1] + step), at[-1] + step)
                if not here.converged:
                    step /= 2
                    if abs(step) < _SMALLEST * max(map(abs, depths)):
                        raise PalpateError(
                            f"No equilibrium beyond {at[-1]:.4g} mm: {here.outcome}.", "Refine the mesh."
                        )
                    continue
                at.append(at[-1] + step)
                states.append(here.state)
                self._hold(here.state, at[-1])
            found.append(here)
        return found

    def relax(self, start: State, depth: float) -> Equilibrium:
        """Relax from a state that is no equilibrium, by pseudo-time steps of a viscosity that fades to nothing.

        Raises
        ------
        PalpateError
            If no equilibrium is found at the depth (mm).
        """
        stiffness = self.solid.material.young_modulus / self.size**2
        coefficient, state, plane = 10 * stiffness, start, self.plane(depth)
        for _ in range(_RELAXATIONS):
            damping = Damping(coefficient, state.u)
            here = self.problem.solve(state, plane, self.touch, _ITERATIONS, damping, _SLACK)
            coefficient *= (0.1 if here.iterations <= 4 else 0.25) if here.converged else 3.0
            state = here.state if here.converged else state
            if coefficient < _FADED * stiffness:
                break
        found = self.solve(state, depth)
        if not found.converged:
            raise PalpateError(f"No equilibrium was found at {depth:.4g} mm: {found.outcome}.", "Refine the mesh.")
        return found

    def _hold(self, state: State, depth: float) -> None:
        """Hold what lies within half the radius of contact."""
        radius = np.hypot(*self.problem.surface.points[:, :2].T)
        touching = self.reach(state, depth) > 0
        middle = radius < _MIDDLE * radius[touching].max(initial=0.0)
        hold = np.where(middle & self.held, _HOLD * self.penalty, 0.0)
        self.touch = self.touch._replace(hold=hold)

    def reach(self, state: State, depth: float) -> FloatArray:
        """Depth (n_points,) in mm of every contact point inside the plane, negative before it."""
        x = self.problem.surface.interpolate(self.solid.nodes + state.u)
        return x[:, 2] - self.plane(depth).point[2]
