"""Continuation of a branch of equilibria as an obstacle moves: predictor, increments, snap-through.

Each increment starts from a polynomial through the last equilibria (the predictor). It is accepted only if it is an
equilibrium and continuous: the energy gained must be equal to the work done, and the monitor must report the same
branch. Otherwise Newton's method has reached another branch, and the increment is shortened. The number of negative
pivots is recorded but is not a criterion: the apex of a flat thin dome bears almost no pressure, and a discrete dome
may be weakly unstable there while its branch continues.

A branch that cannot be followed in increments of the minimum size has ended, at a limit point. The body then snaps
through: pseudo-time steps with a viscosity that decreases to zero lead to the next stable state, and the depth and
the energy lost are reported. The path ends if the monitor reports that later states are not modelled.

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
"""Increment (mm, times the unit) below which a violated energy balance is a jump of the body. By hand."""
_RELEASE_STEP = 0.1
"""Increment (mm, times the unit) below which a lost branch is released. By hand."""
_IMBALANCE = 0.06
"""Maximum relative difference of gained energy and work of a continuous increment. By hand."""
_NOTHING = 1e-9
"""Distance (mm) and energy (mJ), times the unit and its cube, that count as zero. By hand."""
_ROUNDING = 1e-6
"""Share of an increment by which the remaining depth may exceed it as one increment. By hand."""
_ORDER = 2
"""Order of the predictor. Half or twice: 1 % of force, twice 1.6 times the time. By hand."""
_GROWTH = ((10, 2.0), (15, 1.4))
"""Factor on the next increment after at most so many iterations.
Half costs 2.2 times the time and changes forces by 3 %. By hand."""
_STIFFENING = 2.0
"""Exponent of force over depth above which increments shrink. Half: 2 % of force. By hand."""
_SHRINK = 0.8
"""Factor on the next increment after more iterations. By hand."""
_JUMPS = 4
"""Maximum number of jumps of a path. By hand."""
_RELAXATIONS, _FIRST_VISCOSITY, _FADED = 120, 10.0, 1e-3
"""Maximum pseudo-time steps of a jump; over mu/area, first viscosity, and one that counts as zero.
By hand."""
_VISCOSITY, _THICKEN, _FAILED = ((2, 1 / 30), (4, 1 / 4), (8, 1 / 2), (12, 1.0)), 1.5, 4.0
"""Factor on the viscosity after at most so many iterations, after more, after a failure. By hand."""
_SLACK, _JUMP_SLACK = 1e3, 30.0
"""Factor on the tolerance in friction passes before the last, and in pseudo-time steps. By hand."""
_PASSES = 4
"""Maximum passes in which friction limits are corrected. Half or twice: 1 % of force. By hand."""


def _agree(old: FloatArray, new: FloatArray) -> bool:
    """Test whether the friction limits (n,) of two passes differ by at most 2 %; always true for no slip."""
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
    loading, monitor
        Loading, and monitor of branch, contact stabilisation and end.
    spec
        Steps, iterations and tolerance.
    unit
        Factor on the lengths of the spec's steps.
    increments
        Accepted equilibria; the first is the start, at rest if none is given.
    iterations
        Number of Newton iterations so far, rejected increments included.
    jumps
        Whether the path jumps at the end of its branch.
    sensitivity
        Derivatives that are followed up to the first jump, if any; begun by its `start`.
    ended, message
        Reason why the path cannot continue, and a sentence about it; `EndReason.DEPTH_REACHED` while it can.
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
        """Follow the branch to a depth in mm, deeper or back; return whether it was reached (see `ended`)."""
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
        """Relax at a depth in mm to the inverted state near a shape (n, 3) mm; return whether it is stable.

        The search stops at a state that is not `hopeful`: by default, one that the monitor does not call inverted. On
        success the path continues from the state and does not jump.
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
        """Return the equilibrium at a depth; with friction, in passes until history and solution agree.

        In a jump all points are `sliding`; they stick at their places of rest.
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
        """Return the predicted state with the points in contact at the last equilibrium drawn to the obstacle.

        In an extrapolated state some points have lost contact by micrometres. Without them the tangent is nearly
        singular, and the first Newton steps are wasted.
        """
        last = self.last
        self.iterations += 1
        history = last.history._replace(stabilisation=self._stabilisation)
        return self.problem.step(predicted, self.loading.stuck_terms(depth, last.depth, last.state, history))

    def _predict(self, depth: float) -> State:
        """Extrapolate the last equilibria by a polynomial in depth, since the last jump or `turn`."""
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
        """Return the power at which an equilibrium was reached, mJ/mm."""
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
        """Propagate derivatives to an increment; a path without memory needs them at the goal only."""
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
        """End contact stabilisation for the rest of the path."""
        self._released, self._stabilisation = True, np.zeros_like(self._stabilisation)

    def turn(self, way: float = 1.0) -> None:
        """Restart steps and prediction, because the path of the obstacle, and so its power, changes here.

        The path continues towards a larger (`way` 1) or smaller (-1) parameter.
        """
        last, self._way = self.last, way
        power = self.loading.power(last.depth, last.state, last.history, last.loads.force, way)
        self.increments.append(replace(last, jumped=False, power=power))
        self._since, self._step = len(self.increments) - 1, self._first_step

    def restart(self) -> None:
        """Continue from the last increment as from a new start, without jumps."""
        self.increments, self.jumps, self._since = [self.last], False, 0
        self._step = self._first_step

    @property
    def _first_step(self) -> float:
        return min(self.spec.first_step, self.spec.largest_step) * self.unit

    def _jump(self, depth: float) -> bool:
        """End stabilisation, push the patch's middle away, and relax to the next stable state at `depth` mm."""
        last = self.last
        fault = self.monitor.fault(last.state)
        if fault is not None:
            self._end(*fault)
            return False
        if not self.jumps:
            self._end(EndReason.BRANCH_ENDED, "at the end of the branch")
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
            f"because no equilibrium was found: {found.outcome} after {found.iterations} iterations, residual "
            f"{found.residual:.2g} N is above {self.problem.tolerance:.2g} N",
        )
        return False

    def _end(self, ended: EndReason, reason: str) -> None:
        self.ended, self.message = ended, f"The press ended at {self.last.depth:.4g} mm, {reason}."

    def attempt(self, depth: float, start: State) -> bool:
        """Solve one increment to a depth in mm from a predicted state; return whether it was accepted."""
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
        """Relax from a state to the equilibrium near a `shape` (n, 3) mm, with decreasing viscosity.

        The search stops at the first state that is not `hopeful`.
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
