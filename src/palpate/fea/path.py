"""Follow a branch of equilibria as the wall moves: predictor, increments, and the detection of jumps.

Each increment starts from a polynomial through the last equilibria. It is accepted only if it is an equilibrium,
stable (no negative pivot), and *continuous*: the energy gained must be the work done. Where it is not, Newton's
method has fallen onto another branch, and the increment is shortened. A branch that cannot be followed in
increments of the smallest size has ended; then the dome jumps: pseudo-time steps with a viscosity that fades to
zero carry it to the next stable state, and the depth and the energy lost are reported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from palpate.fea.arrays import FloatArray
from palpate.fea.contact import Plane, Touch
from palpate.fea.newton import ContactProblem, Damping, Equilibrium
from palpate.fea.solid import State
from palpate.fea.spec import SolverSpec

_JUMP_STEP_MM = 0.02
"""An increment this small that still breaks the energy balance is a jump of the dome, not of the solver."""
_IMBALANCE = 0.06
"""Greatest share by which the energy gained may miss the work (trapezoid) of a continuous increment."""
_ORDER = 2
_PASSES = 4
"""Most passes in which sticking points and friction limits are corrected."""


def _agree(old: FloatArray, new: FloatArray) -> bool:
    """Whether friction limits (n,) of two passes are the same points, and the same traction within 2 %."""
    if np.isinf(old).any() or np.isinf(new).any():
        return bool(np.array_equal(np.isinf(old), np.isinf(new)))
    return bool(np.abs(new - old).sum() <= 0.02 * new.sum())


"""Degree of the predictor."""


@dataclass(frozen=True)
class Point:
    """One accepted equilibrium of the whole dome.

    Attributes
    ----------
    depth
        mm travel of the wall.
    state
        Displacement and pressure.
    energy
        mJ stored, modelled part.
    force
        (3,) N on the wall, modelled part.
    touch
        What the contact points remember.
    jumped
        Whether a jump led here.
    """

    depth: float
    state: State
    energy: float
    force: FloatArray
    touch: Touch
    jumped: bool = False


@dataclass
class Path:
    """A branch under continuation.

    Attributes
    ----------
    problem
        Solid, contact and linear solver.
    wall
        Plane of the wall at a depth in mm.
    spec
        Steps, iterations and tolerance.
    points
        Accepted equilibria; the first is the start.
    iterations
        Newton iterations spent so far, rejected increments included.
    failure
        Why the path could not go on; empty while it can.
    """

    problem: ContactProblem
    wall: Callable[[float], Plane]
    spec: SolverSpec
    points: list[Point]
    iterations: int = 0
    failure: str = ""
    _step: float = field(default=0.0, init=False)
    _touch: Touch = field(init=False)

    def __post_init__(self) -> None:
        self._step = self.spec.first_step
        self._touch = self.points[0].touch

    def advance(self, depth: float) -> bool:
        """Follow the branch to a depth in mm; False where it could not be reached (see `failure`)."""
        while (left := depth - self.points[-1].depth) > 1e-9:
            step = min(self._step, left)
            if step < left < 1.5 * step:
                step = left / 2
            if not self._increment(step):
                return False
        return True

    def _increment(self, step: float) -> bool:
        last = self.points[-1]
        depth = last.depth + step
        found = self._solve(depth, self._predict(depth))
        if self._acceptable(found, step):
            self._accept(found, depth, jumped=False)
            self._step = self._next_step(step, found.iterations)
            return True
        self._step = step / 2 if found.iterations < self.spec.iterations else step / 3
        if self._step >= self.spec.smallest_step and not (found.converged and step <= _JUMP_STEP_MM):
            return True
        return self._jump(last.depth + min(step, _JUMP_STEP_MM))

    def _next_step(self, step: float, iterations: int) -> float:
        factor = 2.0 if iterations <= 6 else 1.5 if iterations <= 8 else 1.0 if iterations <= 10 else 0.7
        return float(
            np.clip(max(step, self._step if iterations <= 10 else 0) * factor, 0, self.spec.largest_step)
        )

    def _solve(self, depth: float, start: State, damping: Damping | None = None) -> Equilibrium:
        """Equilibrium at a depth; with friction in passes, until sticking points and limits agree with it."""
        plane, last, law = self.wall(depth), self.points[-1], self.problem.law
        surface = self.problem.surface
        touch = last.touch
        if law.friction > 0:
            before = (self._surface_points(last.state), self.wall(last.depth))
            touch = surface.foresee(law, touch, before, (self._surface_points(start), plane))
        for _ in range(_PASSES):
            found = self.problem.solve(start, plane, touch, self.spec.iterations, damping)
            self.iterations += found.iterations
            if law.friction == 0 or not found.converged:
                break
            x = self._surface_points(found.state)
            corrected = surface.correct(law, touch, x, plane)
            if _agree(touch.limit, corrected.limit):
                break
            touch, start = corrected, found.state
        self._touch = touch
        return found

    def _surface_points(self, state: State) -> FloatArray:
        return self.problem.surface.interpolate(self.problem.solid.nodes + state.u)

    def _predict(self, depth: float) -> State:
        """Extrapolate the last equilibria of this branch by a polynomial in depth."""
        since = max((k for k, point in enumerate(self.points) if point.jumped), default=0)
        known = self.points[max(since, len(self.points) - _ORDER - 1) :]
        at = np.array([point.depth for point in known])
        u, p = np.zeros_like(known[0].state.u), np.zeros_like(known[0].state.p)
        for k, point in enumerate(known):
            others = np.delete(at, k)
            share = float(np.prod((depth - others) / (at[k] - others)))
            u += share * point.state.u
            p += share * point.state.p
        return State(u, p)

    def _acceptable(self, found: Equilibrium, step: float) -> bool:
        if not found.converged or found.negative_pivots > 0:
            return False
        last = self.points[-1]
        if len(self.points) < 3:
            return True
        work = 0.5 * (found.force[2] + last.force[2]) * step
        gained = found.energy - last.energy
        tolerance = _IMBALANCE if self.problem.law.friction == 0 else 3 * _IMBALANCE
        return bool(abs(gained - work) <= tolerance * abs(work) + 1e-9)

    def _accept(self, found: Equilibrium, depth: float, *, jumped: bool) -> None:
        plane = self.wall(depth)
        x = self._surface_points(found.state)
        touch = self.problem.surface.settle(self.problem.law, self._touch, x, plane)
        self.points.append(Point(depth, found.state, found.energy, found.force, touch, jumped))

    def _jump(self, depth: float) -> bool:
        """Relax to the next stable state at `depth` mm through a viscosity that fades to zero."""
        material, last = self.problem.solid.material, self.points[-1]
        scale = material.law.shear_modulus / float(self.problem.surface.weight.sum())
        coefficient, state = 10.0 * scale, last.state
        for _ in range(200):
            damping = Damping(coefficient, state.u) if coefficient > 1e-4 * scale else None
            found = self._solve(depth, state, damping)
            if found.converged and (damping is not None or found.negative_pivots <= 0):
                state = found.state
                if damping is None:
                    self._accept(found, depth, jumped=True)
                    self._step = min(self.spec.first_step, self.spec.largest_step)
                    return True
                coefficient /= 30.0 if found.iterations <= 2 else 3.0 if found.iterations <= 6 else 1.5
            else:
                coefficient = max(coefficient, 1e-4 * scale) * 5.0
            if coefficient > 1e6 * scale:
                break
        self.failure = (
            f"at {last.depth:.4g} mm no equilibrium was found: {found.outcome} after {found.iterations} iterations, "
            f"residual {found.residual:.2g} N is above {self.problem.tolerance:.2g} N"
        )
        return False
