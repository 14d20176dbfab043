"""Arc-length continuation of a body under increasing dead loads, past the limit points of the load.

If the load of a branch has a maximum, no equilibrium exists at larger loads. Therefore neither load nor displacement
is prescribed, but the length of the path. Each increment begins along the tangent and is corrected in the plane
orthogonal to it, with the load factor as an additional unknown (Riks 1979, *Int. J. Solids Struct.* 15, 529; Wempner
1971). Each iteration costs one factorisation and two back-substitutions. The negative pivots of the factorisation are
the number of unstable modes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.mechanics.linear import SingularMatrixError
from palpate.mechanics.newton import Problem
from palpate.mechanics.solid import State
from palpate.mechanics.term import DeadLoad

_ITERATIONS, _WANTED = 12, 5
"""Maximum iterations of an increment, and iterations below which its length grows."""
_GROW, _SHRINK = 1.5, 0.4
_SHORTEST = 1e-4
"""Minimum length of an increment over the first."""


@dataclass(frozen=True)
class ArcPoint:
    """An equilibrium of the path.

    Attributes
    ----------
    factor, state
        Load factor, displacement and pressure.
    negative_pivots
        Unstable modes; -1 if the linear solver does not compute them.
    """

    factor: float
    state: State
    negative_pivots: int


@dataclass
class ArcLength:
    """A path from rest.

    Attributes
    ----------
    problem
        Body and linear solver; its tolerance is that of the residual.
    force
        (n, 3) N at the nodes, at a factor of 1.
    step, longest
        First and maximum length of an increment, mm: root mean square displacement over the body.
    points
        Equilibria, the first at rest.
    """

    problem: Problem
    force: FloatArray
    step: float
    longest: float
    points: list[ArcPoint] = field(default_factory=list)

    def __post_init__(self) -> None:
        if not np.abs(self.force.ravel()[self.problem.body.free]).any():
            raise PalpateError(
                "No load acts on a free node.", "Apply a load to nodes that are not fixed.", code="load-missing"
            )
        self._shortest = _SHORTEST * self.step
        if not self.points:
            self.points = [ArcPoint(0.0, self.problem.body.rest(), 0)]

    def advance(self) -> ArcPoint:
        """Follow the path by one increment.

        Raises
        ------
        PalpateError
            If no equilibrium is found in the shortest increment.
        """
        while self.step >= self._shortest:
            found = self._increment(self.step)
            if found is not None:
                point, iterations = found
                self.points.append(point)
                self.step = min(self.step * (_GROW if iterations < _WANTED else 1.0), self.longest)
                return point
            self.step *= _SHRINK
        raise PalpateError(
            f"The path ends at {self.points[-1].factor:.4g} times the load: no equilibrium follows within "
            f"{self.step:.2g} mm.",
            "Refine the mesh.",
            code="path-ended",
        )

    def go_back(self, step: float) -> None:
        """Remove the last point, and continue from the one before by a length in mm."""
        self.points.pop()
        self.step = step

    def softest_mode(self, rounds: int = 6) -> FloatArray:
        """Return the tangent's mode (n, 3) closest to zero at the last point, by inverse iteration."""
        last = self.points[-1]
        self._factor(last.state, last.factor)
        shape = np.random.default_rng(0).standard_normal(self.force.shape)
        for _ in range(rounds):
            shape = self.problem.back_substitute(shape.ravel() / np.abs(shape).max())
        return shape / float(np.abs(shape).max())

    def _increment(self, length: float) -> tuple[ArcPoint, int] | None:
        """Return the equilibrium `length` mm along the path, and iterations; `None` if it is not found."""
        last, body = self.points[-1], self.problem.body
        state, factor = last.state, last.factor
        try:
            self._factor(state, factor)
            answer = self.problem.back_substitute(self.force.ravel())
            tangent = answer * self._way(answer) / self._size(answer)
            du, gain = length * tangent, length * self._way(answer) / self._size(answer)
            for iteration in range(_ITERATIONS):
                state = state.moved(du, body.recover_pressure(du), 1.0)
                factor += gain
                pivots = self._factor(state, factor)
                if pivots is None:
                    return None
                residual = self.problem.assembly.system.residual
                if float(np.abs(residual[body.free]).max()) <= self.problem.tolerance * max(abs(factor), 1e-3):
                    return ArcPoint(factor, state, pivots), iteration
                answer = self.problem.back_substitute(self.force.ravel())
                left = self.problem.back_substitute(-residual)
                gain = -self._inner(tangent, left) / self._inner(tangent, answer)
                du = left + gain * answer
        except SingularMatrixError:
            return None
        return None

    def _factor(self, state: State, factor: float) -> int | None:
        """Factor the tangent; return its negative pivots, or `None` if a cell is inverted."""
        loads = self.problem.assemble(state, (DeadLoad(self.force, factor),))
        if not np.isfinite(loads.elastic):
            return None
        return self.problem.refactor()

    def _way(self, answer: FloatArray) -> float:
        """Return 1 if the path continues along the answer towards larger loads, else -1."""
        if len(self.points) < 2:
            return 1.0
        went = self.points[-1].state.u - self.points[-2].state.u
        return 1.0 if self._inner(went, answer) > 0 else -1.0

    def _inner(self, a: FloatArray, b: FloatArray) -> float:
        """Return the mean product of displacements (n, 3) over the body."""
        volume = self.problem.body.nodal_volume
        return float(np.einsum("n,ni,ni->", volume, a, b) / volume.sum())

    def _size(self, u: FloatArray) -> float:
        return float(np.sqrt(self._inner(u, u)))
