"""Follow a branch of equilibria as an obstacle moves: predictor, increments, limit points and snap-through.

Each increment starts from a polynomial through the last equilibria (the predictor). It is accepted only if it is an
equilibrium, *continuous*: the energy gained must be the work done, and the monitor must see the same branch. Where it
is not, Newton's method has fallen onto another branch, and the increment is cut back. The number of negative pivots
is recorded: a flat thin dome is held by almost no pressure at its apex, and a discrete one may be weakly unstable
there while its branch goes on. A branch that cannot be followed in increments of the smallest size has ended, at a
limit point; then the body snaps through: pseudo-time steps with a viscosity that fades to zero carry it to the next
stable state, and the depth and the energy lost are reported. Where the monitor says that what follows is not
modelled, the path ends.

Lengths of increments are those of the spec times `unit`, so a body ten times as large is solved in the same steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from palpate.core import FloatArray
from palpate.mechanics.friction import ContactHistory
from palpate.mechanics.increment import Increment
from palpate.mechanics.loading import PathLoading
from palpate.mechanics.monitor import EndReason, Monitor
from palpate.mechanics.newton import Equilibrium, Loads, Problem, SolveOutcome
from palpate.mechanics.sensitivity import IncrementTransition, Sensitivity
from palpate.mechanics.solid import State
from palpate.mechanics.spec import BASE_RADIUS, SolverSpec
from palpate.mechanics.term import Damping

_JUMP_STEP = 0.02
"""An increment this small (mm, times the unit) that still breaks the energy balance is a jump of the body."""
_RELEASE_STEP = 0.1
"""Increment (mm, times the unit) below which a lost branch is let go."""
_IMBALANCE = 0.06
"""Greatest share by which the energy gained may miss the work (trapezoid) of a continuous increment."""
_NOTHING = 1e-9
"""Distance (mm) and energy (mJ), times the unit and its cube, that count as none."""
_ROUNDING = 1e-6
"""Share of an increment by which what is left may exceed it and still count as it."""
_ORDER = 2
"""Order of the predictor."""
_GROWTH = ((10, 2.0), (15, 1.4))
"""Factor on the next increment after one of at most so many iterations
(docs/design_notes/mechanics.md)."""
_STIFFENING = 2.0
"""Exponent of force over depth beyond which a skin stiffens, and increments shrink by its square."""
_SHRINK = 0.8
"""Factor on the next increment after one of more iterations."""
_JUMPS = 4
"""Most jumps of a path."""
_RELAXATIONS, _FIRST_VISCOSITY, _FADED = 120, 10.0, 1e-3
"""Most pseudo-time steps of a jump, the first viscosity over mu/area, and that at which it has faded."""
_VISCOSITY, _THICKEN, _FAILED = ((2, 1 / 30), (4, 1 / 4), (8, 1 / 2), (12, 1.0)), 1.5, 4.0
"""Factor on the viscosity after a pseudo-time step of at most so many iterations, of more, and after a failed one."""
_SLACK, _JUMP_SLACK = 1e3, 30.0
"""Slack on the tolerance of friction passes that are not the last, and of pseudo-time steps."""
_PASSES = 4
"""Most passes in which friction limits are corrected."""


def _agree(old: FloatArray, new: FloatArray) -> bool:
    """Whether the friction limits (n,) of two passes are the same traction within 2 %; no slip has but one."""
    if np.isinf(new).any():
        return True
    return bool(np.abs(new - old).sum() <= 0.02 * new.sum())


@dataclass
class Continuation:
    """A branch under continuation.

    Attributes
    ----------
    problem
        Body and linear solver.
    loading
        What moves.
    monitor
        Which branch a state belongs to, how contact is stabilised, and what ends the path.
    spec
        Steps, iterations and tolerance.
    unit
        Factor on the lengths of the spec's steps.
    increments
        Accepted equilibria; the first is the start, at rest if none is given.
    iterations
        Newton iterations spent so far, rejected increments included.
    jumps
        Whether the path jumps where its branch ends.
    sensitivity
        Follows derivatives up to the first jump, if there is one; begun by its `start`.
    ended, message
        Why the path could not go on, and that in one sentence; `EndReason.DEPTH_REACHED` while it can.
    """

    problem: Problem
    loading: PathLoading
    monitor: Monitor
    spec: SolverSpec
    unit: float = 1.0
    increments: list[Increment] = field(default_factory=list)
    iterations: int = 0
    jumps: bool = True
    sensitivity: Sensitivity | None = None
    ended: EndReason = EndReason.DEPTH_REACHED
    message: str = ""
    _step: float = field(default=0.0, init=False)
    _history: ContactHistory = field(init=False)
    _stabilisation: FloatArray = field(init=False)
    _released: bool = field(default=False, init=False)
    _way: float = field(default=1.0, init=False)
    _since: int = field(default=0, init=False)
    _goal: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        if not self.increments:
            rest = Loads(0.0, 0.0, np.zeros(3))
            self.increments = [Increment(0.0, self.problem.body.rest(), rest, self.loading.start())]
        self._step = self.spec.first_step * self.unit
        self._history = self.increments[0].history
        self._stabilisation = self._history.stabilisation

    @property
    def last(self) -> Increment:
        """The increment reached."""
        return self.increments[-1]

    def advance(self, depth: float) -> bool:
        """Follow the branch to a depth in mm, deeper or back; False where it could not be reached (see `ended`)."""
        self._goal = depth
        while abs(left := depth - self.last.depth) > _NOTHING * self.unit:
            step = min(self._step, abs(left))
            if (1.0 + _ROUNDING) * step < abs(left) < 1.5 * step:
                step = abs(left) / 2
            way = 1.0 if left > 0 else -1.0
            if way != self._way:
                self._way, self._since = way, len(self.increments) - 1
            if not self._increment(step, way):
                return False
        return True

    def settle(
        self, depth: float, shape: FloatArray, start: State, hopeful: Callable[[State], bool] | None = None
    ) -> bool:
        """Relax at a depth in mm to the inverted state near a shape (n, 3) mm; whether it rests there.

        It is given up at a state on the way that is not `hopeful`: by default, one that the monitor does not call
        inverted. On success the path goes on from the state and does not jump.
        """
        self.release()
        hopeful = hopeful or (lambda state: self.monitor.inverted(depth, state))
        found = self.relax(depth, shape, start, hopeful)
        if not found.converged:
            return False
        self._accept(found, depth, jumped=True)
        self.restart()
        return True

    def _increment(self, step: float, way: float) -> bool:
        last, jump = self.last, _JUMP_STEP * self.unit
        depth = last.depth + way * step
        found = self._solve(depth, self._stuck(depth, self._predict(depth)))
        if self._acceptable(found, depth):
            tension = self.monitor.tension(depth, found.state, self._stabilisation)
            if tension <= self.spec.adhesion * self.monitor.modulus:
                self._accept(found, depth, jumped=False)
                self._step = self._next_step(step, found.iterations)
                return True
            if step <= _RELEASE_STEP * self.unit:
                return self._jump(depth)
        self._step = step / 2 if found.iterations < self.spec.iterations else step / 3
        if step <= _RELEASE_STEP * self.unit and (fault := self.monitor.fault(last.state)) is not None:
            self._end(*fault)
            return False
        if self._step >= self.spec.smallest_step * self.unit and not (found.converged and step <= jump):
            return True
        return self._jump(last.depth + way * min(step, jump))

    def _next_step(self, step: float, iterations: int) -> float:
        factor = next((factor for most, factor in _GROWTH if iterations <= most), _SHRINK)
        largest = self.spec.largest_step * self.unit
        edge = self.spec.edge_share * self.problem.length
        advance = self.loading.max_increment(self.last.depth, edge, BASE_RADIUS * self.unit)
        advance *= min(1.0, (_STIFFENING / max(self._exponent, _STIFFENING)) ** 2)
        largest = min(largest, max(advance, self.spec.first_step * self.unit))
        return min(max(step, self._step) * factor, largest)

    @property
    def _exponent(self) -> float:
        """Exponent n of the force as a power of the depth, from the last two increments."""
        thrust = self.loading.axial_force
        (d0, f0), (d1, f1) = ((point.depth, thrust(point.loads.force)) for point in self.increments[-2:])
        return d1 * (f1 - f0) / ((d1 - d0) * f1) if f1 > 0 and d1 != d0 else 0.0

    def _solve(
        self, depth: float, start: State, damping: Damping | None = None, *, sliding: bool = False
    ) -> Equilibrium:
        """Equilibrium at a depth; with friction in passes, until sticking places and limits agree with it.

        In a jump all points are `sliding`; they stick where they come to rest.
        """
        last = self.last
        history, passes = last.history._replace(stabilisation=self._stabilisation), 0
        if sliding:
            history = history._replace(limit=np.zeros_like(history.limit))
        rough = (self.loading.remembers and not sliding) or damping is not None
        while True:
            terms = self.loading.terms(depth, history) + (() if damping is None else (damping,))
            slack = _JUMP_SLACK if damping is not None else _SLACK if rough else 1.0
            found = self.problem.solve(start, terms, self.spec.iterations, slack, descend=damping is not None)
            self.iterations += found.iterations
            self._history, passes = history, passes + 1
            if not rough or damping is not None or not found.converged:
                return found
            history = self.loading.correct(history, (last.depth, last.state), (depth, found.state))
            start = found.state
            rough = passes < _PASSES and not _agree(self._history.limit, history.limit)

    def _stuck(self, depth: float, predicted: State) -> State:
        """The predicted state, with the points that touch at the last equilibrium drawn to the obstacle.

        An extrapolated state has lost contact here and there by micrometres; without those points the tangent is
        nearly singular, and Newton's first steps are lost on it.
        """
        last = self.last
        self.iterations += 1
        history = last.history._replace(stabilisation=self._stabilisation)
        return self.problem.step(predicted, self.loading.stuck_terms(depth, last.depth, last.state, history))

    def _predict(self, depth: float) -> State:
        """Extrapolate the last equilibria, since a jump or a turn of the obstacle, by a polynomial in depth."""
        known = self.increments[max(self._since, len(self.increments) - _ORDER - 1) :]
        at = np.array([point.depth for point in known])
        u, p = np.zeros_like(known[0].state.u), np.zeros_like(known[0].state.p)
        for k, point in enumerate(known):
            others = np.delete(at, k)
            share = float(np.prod((depth - others) / (at[k] - others)))
            u += share * point.state.u
            p += share * point.state.p
        return State(u, p)

    def _acceptable(self, found: Equilibrium, depth: float) -> bool:
        last, monitor = self.last, self.monitor
        if not found.converged or monitor.inverted(depth, found.state) != monitor.inverted(last.depth, last.state):
            return False
        if len(self.increments) < 3:
            return True
        power = self._power(depth, found)
        work = 0.5 * (power + last.power) * (depth - last.depth)
        gained = sum(found.loads[:2]) - sum(last.loads[:2])
        tolerance = 3 * _IMBALANCE if self.loading.remembers else _IMBALANCE
        return bool(abs(gained - work) <= tolerance * abs(work) + _NOTHING * self.unit**3)

    def _power(self, depth: float, found: Equilibrium) -> float:
        """Power with which an equilibrium was reached, mJ/mm."""
        return self.loading.power(depth, found.state, self._history, found.loads.force, -self._way)

    def _accept(self, found: Equilibrium, depth: float, *, jumped: bool) -> None:
        if self.sensitivity is not None:
            self._differentiate(self.sensitivity, found.state, depth, jumped=jumped)
        power = self._power(depth, found)
        history, lost = self.loading.update_history(self._history, depth, found.state)
        self.increments.append(
            Increment(
                depth,
                found.state,
                found.loads._replace(potential=found.loads.potential - lost),
                history,
                jumped,
                found.negative_pivots,
                self.monitor.tension(depth, found.state, self._stabilisation),
                self.last.dissipated + lost,
                power,
            )
        )
        stabilisation = None if self._released else self.monitor.stabilisation(depth, found.state)
        if stabilisation is not None:
            self._stabilisation = stabilisation

    def _differentiate(self, sensitivity: Sensitivity, state: State, depth: float, *, jumped: bool) -> None:
        """Carry derivatives on to an increment; a path without memory needs them only where it is going."""
        if jumped:
            self.sensitivity = None
            return
        asked = abs(depth - self._goal) <= _NOTHING * self.unit
        if asked or self.loading.remembers:
            last = self.last
            earlier = last.history._replace(stabilisation=self._stabilisation)
            step = IncrementTransition(
                len(self.increments), last.depth, depth, last.state, state, earlier, self._history
            )
            sensitivity.accept(step, memory=self.loading.remembers, asked=asked)

    def release(self) -> None:
        """Let go of what the monitor stabilises, for the rest of the path."""
        self._released, self._stabilisation = True, np.zeros_like(self._stabilisation)

    def turn(self, way: float = 1.0) -> None:
        """Begin anew with steps and prediction: what moves changes its way here, and so its power.

        From here it goes the `way` of a greater (1) or lesser (-1) parameter.
        """
        last, self._way = self.last, way
        power = self.loading.power(last.depth, last.state, last.history, last.loads.force, way)
        self.increments.append(replace(last, jumped=False, power=power))
        self._since, self._step = len(self.increments) - 1, self._first_step

    def restart(self) -> None:
        """Go on from the increment reached as from a new start, and do not jump."""
        self.increments, self.jumps, self._since = [self.last], False, 0
        self._step = self._first_step

    @property
    def _first_step(self) -> float:
        return min(self.spec.first_step, self.spec.largest_step) * self.unit

    def _jump(self, depth: float) -> bool:
        """Let go of the patch, push its middle off the obstacle, and relax to the next stable state at `depth` mm."""
        last = self.last
        fault = self.monitor.fault(last.state)
        if fault is not None:
            self._end(*fault)
            return False
        if not self.jumps:
            self._end(EndReason.BRANCH_ENDED, "where the branch ends")
            return False
        self.release()
        if sum(increment.jumped for increment in self.increments) >= _JUMPS:
            self._end(EndReason.NOT_CONVERGED, f"after {_JUMPS} jumps: no branch can be followed further")
            return False
        for push in (0.0, 1.0, 2.0) if self.monitor.inverted(last.depth, last.state) else (1.0, 2.0):
            shape = self.monitor.perturbed(last.depth, last.state, push * self.problem.length)
            found = self.relax(depth, shape, last.state)
            if found.converged:
                self._accept(found, depth, jumped=True)
                self._since = len(self.increments) - 1
                self._step = self._first_step
                return True
        self._end(
            EndReason.NOT_CONVERGED,
            f"where no equilibrium was found: {found.outcome} after {found.iterations} iterations, residual "
            f"{found.residual:.2g} N is above {self.problem.tolerance:.2g} N",
        )
        return False

    def _end(self, ended: EndReason, reason: str) -> None:
        self.ended, self.message = ended, f"The press ended at {self.last.depth:.4g} mm, {reason}."

    def attempt(self, depth: float, start: State) -> bool:
        """Go on to a depth in mm in one increment from a predicted state; whether it was accepted."""
        found = self._solve(depth, self._stuck(depth, start))
        accepted = self._acceptable(found, depth)
        if accepted:
            self._accept(found, depth, jumped=False)
        return accepted

    def relax(
        self,
        depth: float,
        shape: FloatArray,
        start: State,
        hopeful: Callable[[State], bool] = lambda state: True,
    ) -> Equilibrium:
        """Relax from a state to the equilibrium near a `shape` (n, 3) mm, under a viscosity that fades to zero.

        It is given up at the first state on the way that is not `hopeful`.
        """
        scale = self.problem.body.shear_modulus / self.monitor.area
        coefficient, origin = _FIRST_VISCOSITY * scale, shape
        for _ in range(_RELAXATIONS):
            found = self._solve(depth, start, Damping(coefficient, origin), sliding=True)
            if found.converged:
                start, origin = found.state, found.state.u
                if not hopeful(start):
                    return replace(found, outcome=SolveOutcome.DIVERGED)
                if coefficient < _FADED * scale:
                    found = self._solve(depth, start, sliding=True)
                    if found.converged:
                        return found
                    coefficient *= 100.0
                coefficient *= next((factor for most, factor in _VISCOSITY if found.iterations <= most), _THICKEN)
            else:
                coefficient *= _FAILED
        return found
