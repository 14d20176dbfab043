"""Equilibrium by Newton's method: one increment, from a predicted state to a converged one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray
from palpate.mechanics.element import System
from palpate.mechanics.linear import LinearSolver, SingularMatrixError
from palpate.mechanics.solid import Body, State
from palpate.mechanics.term import Assembly, Term

_TRIALS = 5
"""Maximum number of trials of a line search. By hand."""
_SLOPE_FALL = 0.5
"""Share of the first slope at which a line search ends. By hand."""
_CLOSE = 1e3
"""Residual over the tolerance below which the maximum number of iterations is doubled. By hand."""
_BLOW_UP = 10.0
"""Maximum slope after a step over the first slope, if that is positive. By hand."""
_FIRST_SHIFT, _SHIFTS = 1e-3, 8
"""First shift of an indefinite tangent, over mu/T² and nodal volume; maximum number. By hand."""


class SolveOutcome(StrEnum):
    """Outcome of an increment."""

    CONVERGED = "converged"
    TOO_MANY_ITERATIONS = "too many iterations"
    DIVERGED = "residual grew"
    INVERTED_CELL = "a cell turned inside out"
    SINGULAR = "singular matrix"


class Loads(NamedTuple):
    """Energies and force of a state, of the modelled part.

    Attributes
    ----------
    elastic
        Stored elastic energy, mJ; infinite if a cell is inverted.
    potential
        Energy of the added terms, mJ: contact penalty and sticking springs, dead loads.
    force
        (3,) N on the obstacle.
    """

    elastic: float
    potential: float
    force: FloatArray


@dataclass(frozen=True)
class Equilibrium:
    """Result of an increment.

    Attributes
    ----------
    outcome
        Reason of the end.
    state
        The last state; an equilibrium only if `outcome` is converged.
    loads
        Energies and force of the modelled part.
    residual
        Maximum out-of-balance force of a degree of freedom, N.
    iterations
        Number of Newton iterations.
    negative_pivots
        Inertia of the last tangent; 0 on a stable branch, -1 unknown.
    history
        Residual of every iteration, N.
    """

    outcome: SolveOutcome
    state: State
    loads: Loads
    residual: float
    iterations: int
    negative_pivots: int
    history: tuple[float, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether the state is an equilibrium."""
        return self.outcome is SolveOutcome.CONVERGED


class Problem:
    """A body and its linear solver: assembles and solves one increment at a time.

    Parameters
    ----------
    body
        The body.
    linear
        Sparse solver, which analyses the pattern here.
    tolerance
        Maximum out-of-balance force in N at convergence.
    length
        Thickness of the body in mm, the scale of steps and shifts.
    """

    def __init__(self, body: Body, linear: LinearSolver, tolerance: float, length: float) -> None:
        self.body, self.linear, self.tolerance, self.length = body, linear, tolerance, length
        linear.analyze(body.pattern)
        self._assembled, self._whole = body.rest(), False
        self._system = System(np.empty(len(body.pattern.column)), np.empty(body.nodes.size))
        self._assembly = Assembly(
            nodes=body.nodes,
            free=body.free,
            place=body.place,
            diagonal=body.pattern.start[:-1],
            volume=body.nodal_volume,
            system=self._system,
        )

    def assemble(self, state: State, terms: Sequence[Term]) -> Loads:
        """Assemble all terms and the residual of the body; its tangent is added by `refactor`."""
        self._system.data[:] = 0.0
        self._system.residual[:] = 0.0
        energy, potential, force = self.body.add_residual(state, self._system.residual), 0.0, np.zeros(3)
        self._assembled, self._whole = state, False
        if np.isfinite(energy):
            for term in terms:
                share = term.assemble(state, self._assembly)
                potential += share.energy
                force += share.force
        return Loads(energy, potential, force)

    def solve(
        self, start: State, terms: Sequence[Term], iterations: int, slack: float = 1.0, *, descend: bool = False
    ) -> Equilibrium:
        """Find the equilibrium near a predicted state `start`.

        Parameters
        ----------
        start, terms
            Predicted state, and terms that act on the body.
        iterations
            Maximum number of Newton iterations; doubled if the residual is then within 1000 times the tolerance.
        slack
            Factor on the tolerance.
        descend
            Whether every step descends, as to a minimum: an indefinite tangent is shifted.

        Returns
        -------
        Equilibrium
            The result, with the reason if it did not converge.
        """
        state, pivots = start, -1
        history: list[float] = []
        loads = self.assemble(state, terms)
        most = iterations
        for iteration in range(2 * iterations + 1):
            if not np.isfinite(loads.elastic):
                return self._end(SolveOutcome.INVERTED_CELL, state, loads, history, pivots)
            residual = self._system.residual[self.body.free]
            history.append(float(np.abs(residual).max(initial=0.0)))
            if not np.isfinite(history[-1]):
                return self._end(SolveOutcome.DIVERGED, state, loads, history, pivots)
            if history[-1] <= slack * self.tolerance and iteration > 0:
                return self._end(SolveOutcome.CONVERGED, state, loads, history, pivots)
            if iteration == iterations and history[-1] < _CLOSE * self.tolerance:
                most = 2 * iterations
            if iteration == most:
                break
            try:
                pivots, step = self._direction(residual, descend=descend)
            except SingularMatrixError:
                return self._end(SolveOutcome.SINGULAR, state, loads, history, pivots)
            state, loads = self._search(state, step, float(residual @ step), terms)
        return self._end(SolveOutcome.TOO_MANY_ITERATIONS, state, loads, history, pivots)

    @property
    def assembly(self) -> Assembly:
        """The linear system to which terms are added."""
        return self._assembly

    def factor(self, state: State, terms: Sequence[Term]) -> None:
        """Factor the tangent at a state, for `back_substitute`.

        Raises
        ------
        SingularMatrixError
            If it has no inverse.
        """
        self.assemble(state, terms)
        self.refactor()

    def refactor(self) -> int:
        """Factor the tangent assembled last; return the number of its negative pivots, -1 if unknown.

        Raises
        ------
        SingularMatrixError
            If it has no inverse.
        """
        if not self._whole:
            self.body.add_tangent(self._assembled, self._system.data)
            self._whole = True
        return self.linear.refactor(self._system.data)

    def back_substitute(self, force: FloatArray) -> FloatArray:
        """Return the displacement (n, 3) mm of the factored tangent under forces (3 n,) N."""
        return self._scatter(self.linear.solve(force[self.body.free]))

    def step(self, start: State, terms: Sequence[Term]) -> State:
        """Take one linear step of at most the body's thickness.

        Return `start` itself if the tangent is singular or a cell is inverted.
        """
        if not np.isfinite(self.assemble(start, terms).elastic):
            return start
        try:
            _, step = self._direction(self._system.residual[self.body.free], descend=False)
        except SingularMatrixError:
            return start
        du = self._scatter(step)
        factor = min(1.0, self.length / max(float(np.abs(du).max()), 1e-300))
        return start.moved(du, self.body.recover_pressure(du), factor)

    def _scatter(self, step: FloatArray) -> FloatArray:
        """Return the displacement (n, 3) mm of a step of the free degrees of freedom."""
        du = np.zeros(self.body.nodes.shape)
        du.ravel()[self.body.free] = step
        return du

    def _direction(self, residual: FloatArray, *, descend: bool) -> tuple[int, FloatArray]:
        """Return negative pivots and Newton step; to `descend`, an indefinite tangent is shifted first."""
        pivots = negative = self.refactor()
        shift = _FIRST_SHIFT * self.body.shear_modulus / self.length**2
        for _ in range(_SHIFTS if descend else 0):
            if negative <= 0:
                break
            self._system.data[self._assembly.diagonal] += shift * np.repeat(self._assembly.volume, 3)[self.body.free]
            negative = self.refactor()
            shift *= 9.0
        return pivots, self.linear.solve(-residual)

    def _search(self, state: State, step: FloatArray, slope: float, terms: Sequence[Term]) -> tuple[State, Loads]:
        """Search along a step until the slope of the energy is small enough (Matthies & Strang 1979)."""
        du = self._scatter(step)
        dp = self.body.recover_pressure(du)
        factor = min(1.0, self.length / max(float(np.abs(du).max()), 1e-300))
        low, low_slope = 0.0, slope
        for trial in range(_TRIALS):
            moved = state.moved(du, dp, factor)
            loads = self.assemble(moved, terms)
            if not np.isfinite(loads.elastic):
                factor *= 0.5
                continue
            here = float(self._system.residual[self.body.free] @ step)
            if trial == _TRIALS - 1:
                break
            if slope >= 0:  # toward a saddle there is no minimum to bracket; the step must only not blow up
                if abs(here) <= _BLOW_UP * slope:
                    break
                factor *= 0.25
                continue
            if here <= _SLOPE_FALL * abs(slope):
                break
            factor = max(low + (factor - low) * low_slope / (low_slope - here), 0.1 * factor)
        return moved, loads

    @staticmethod
    def _end(outcome: SolveOutcome, state: State, loads: Loads, history: list[float], pivots: int) -> Equilibrium:
        return Equilibrium(
            outcome=outcome,
            state=state,
            loads=loads,
            residual=history[-1] if history else np.inf,
            iterations=max(len(history) - 1, 0),
            negative_pivots=pivots,
            history=tuple(history),
        )
