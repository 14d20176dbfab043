"""Derivatives of a path with respect to its inputs, by one back-substitution each.

In equilibrium the residual vanishes, ``r(u, q, h) = 0``, for every value of a parameter q. The derivative of the
field therefore follows from the tangent K of Newton's method,

    K du/dq = - dr/dq - (dr/dh) dh/dq.

The history h (sticking places and limits) has its own derivative, which is propagated from increment to increment by
the derivative of the rules that update the history (Michaleris, Tortorelli & Vidal, *Int. J. Numer. Meth. Eng.* 37,
1994: direct differentiation of transient problems). The explicit derivatives on the right are central differences of
one assembly, of residuals and of the contact rules, at a fixed state. They are exact to rounding, and laws, obstacles
and skins need not provide any. If the friction limit depends on the pressure, the tangent is that of Newton's method,
which fixes the limit, and the rest is iterated.

With half a body, a parameter may break the mirror symmetry. The derivative is then antisymmetric, and is solved by a
body of the same cells with antisymmetric conditions on its mirror plane (`Sensitivity.across`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.mechanics.element import System
from palpate.mechanics.friction import ContactHistory, arrival
from palpate.mechanics.loading import ContactLoading
from palpate.mechanics.newton import Problem
from palpate.mechanics.obstacle import Obstacle
from palpate.mechanics.solid import Solid, State

_SIDES = (1.0, -1.0)
"""Signs of a central difference."""
_STEP = 1e-5
"""Half the difference of the path's own parameter, mm. By hand."""
_SLOWEST = 0.02
"""Minimum approach rate of a point to the obstacle, over the maximum. By hand."""
_EDGE_POWER = 1.5
"""Power of the distance from sticking points by which the derivative of a free point's place varies.
By hand."""
_LIMIT_ROUNDS = 3
"""Number of rounds in which the friction limit is updated by the derivative of the pressure. By hand."""


@dataclass(frozen=True)
class Variation:
    """A parameter, and the inputs of the path at slightly larger and smaller values of it.

    Attributes
    ----------
    name
        Name of the parameter.
    step
        Half the difference of the values; small, since displacement and history are moved as far along their
        derivatives.
    above, below
        Loading with the parameter larger and smaller.
    solids
        Body with the parameter larger and smaller; None if it does not depend on it.
    lasting
        Whether the parameter has changed since rest; otherwise it changes at the increment alone.
    antisymmetric
        Whether it breaks the mirror symmetry of half a body.
    sideways
        Whether it moves the obstacle only within its own surface, so that no time of contact depends on it.
    """

    name: str
    step: float
    above: ContactLoading
    below: ContactLoading
    solids: tuple[Solid, Solid] | None = None
    lasting: bool = True
    antisymmetric: bool = False
    sideways: bool = False

    def loading(self, side: float) -> ContactLoading:
        """Return the loading with the parameter larger (1) or smaller (-1)."""
        return self.above if side > 0 else self.below


class StateDerivative(NamedTuple):
    """Derivative by one parameter: displacement (n, 3) mm, force (3,) N of the modelled part, and history."""

    u: FloatArray
    force: FloatArray
    history: ContactHistory


class IncrementTransition(NamedTuple):
    """An increment to be differentiated.

    Attributes
    ----------
    number
        Number of the increment in the path; 0 at rest.
    start, end
        Parameter of the path before and after, mm.
    before, after
        Last equilibrium, and the one reached.
    earlier, history
        Contact history of the last equilibrium, and the one with which the increment was solved.
    """

    number: int
    start: float
    end: float
    before: State
    after: State
    earlier: ContactHistory
    history: ContactHistory


class _Arrivals(NamedTuple):
    """Points in new contact: which (n,), distance on the path (n,) mm, pace (n,) and drift (n, 3) before.

    Pace is the derivative of the penetration, drift that of the place on the obstacle, both by the path's parameter.
    """

    fresh: BoolArray
    after: FloatArray
    pace: FloatArray
    drift: FloatArray


@dataclass
class Sensitivity:
    """Derivatives along a path.

    Attributes
    ----------
    problem, loading
        Body with linear solver, and loading, of the path.
    variations
        The parameters.
    across
        Body with antisymmetric conditions on its mirror plane; needed if a variation is `antisymmetric`.
    rates
        Derivative at the last increment, by name.
    found
        Derivatives of every requested increment, by its number in the path: rates by name.
    """

    problem: Problem
    loading: ContactLoading
    variations: tuple[Variation, ...]
    across: Problem | None = None
    rates: dict[str, StateDerivative] = field(default_factory=dict)
    found: dict[int, dict[str, StateDerivative]] = field(default_factory=dict)
    _pace: FloatArray = field(init=False)
    _still: ContactHistory = field(init=False)
    _ahead: dict[str, tuple[float, FloatArray]] = field(default_factory=dict, init=False)

    def start(self, history: ContactHistory) -> None:
        """Begin at rest, with this history."""
        self._still = ContactHistory(*(np.zeros_like(part) for part in history))
        self._pace = np.zeros_like(self.problem.body.nodes)
        self.rates = {each.name: StateDerivative(self._pace, np.zeros(3), self._still) for each in self.variations}

    def stand(self, number: int, at: float, state: State, history: ContactHistory) -> None:
        """Differentiate an equilibrium of the path by itself, without contact memory."""
        self.start(history)
        self.accept(IncrementTransition(number, at, at, state, state, history, history), memory=False, asked=True)

    def accept(self, step: IncrementTransition, *, memory: bool, asked: bool) -> None:
        """Differentiate an increment; with `memory`, also the history after it.

        If it is not `asked` for, only inputs of later increments are computed: no force, and no parameter that
        changes at the increment alone.
        """
        variations = [each for each in self.variations if asked or each.lasting]
        self._factor(step, variations)
        arrivals = self._arrive(step) if memory else None
        rates = dict(self.rates)
        for each in variations:
            old = self.rates[each.name]
            history = old.history
            if each.lasting and arrivals is not None:
                history = self._corrected(each, step, old, arrivals)
            u = self._solve(each, step, history)
            for _ in range(_LIMIT_ROUNDS if self._limited(each) else 0):
                history = history._replace(limit=self._limits(each, step, u))
                u = self._solve(each, step, history)
            force = old.force
            if asked:
                high, low = (self._assemble(each, step, side, history, u)[1] for side in _SIDES)
                force = (high - low) / (2 * each.step)
            kept = self._stored(each, step, u, history) if each.lasting and memory else old.history
            rates[each.name] = StateDerivative(u, force, kept)
        if memory:
            self._pace = self._solve(self._path, step, self._still)
        if asked:
            self.found[step.number] = rates
        self.rates = {
            each.name: rates[each.name] if each.lasting else self.rates[each.name] for each in self.variations
        }

    @staticmethod
    def _limited(each: Variation) -> bool:
        return 0 < each.above.law.friction < np.inf

    def _factor(self, step: IncrementTransition, variations: Sequence[Variation]) -> None:
        """Factor the tangents at the end of a step that these variations need."""
        terms = self.loading.terms(step.end, step.history)
        for problem in {id(each): each for each in map(self._problem, variations)}.values():
            problem.factor(step.after, terms)

    def _problem(self, each: Variation) -> Problem:
        return self.across if each.antisymmetric and self.across is not None else self.problem

    def _solve(self, each: Variation, step: IncrementTransition, rate: ContactHistory) -> FloatArray:
        """Return the derivative (n, 3) mm of the displacement for that of the history."""
        high, low = (self._assemble(each, step, side, rate)[0] for side in _SIDES)
        return self._problem(each).back_substitute((low - high) / (2 * each.step))

    def _assemble(
        self,
        each: Variation,
        step: IncrementTransition,
        side: float,
        rate: ContactHistory,
        u: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return residual (3 n,) N and force (3,) N at the end of a step, or of that state moved along `u`."""
        loading, by = each.loading(side), side * each.step
        own = self.problem.assembly
        to = own._replace(nodes=loading.nodes, system=System(own.system.data, np.zeros(own.nodes.size)))
        state = step.after if u is None else State(step.after.u + by * u, step.after.p)
        if each.solids is not None and u is None:
            each.solids[0 if side > 0 else 1].add_residual(state, to.system.residual)
        share = loading.contact(step.end, _moved(step.history, rate, by)).add_residual(state, to)
        return to.system.residual, share.force

    def _arrive(self, step: IncrementTransition) -> _Arrivals:
        """Return the points in new contact in an increment, the time of contact, and their rates before it."""
        fresh = (step.earlier.limit == 0) & (step.history.limit > 0)
        reach, place = self._foot_rate(self._path, step, self._pace)
        slowest = _SLOWEST * float(np.abs(reach[fresh] if fresh.any() else reach).max())
        area = self.loading.surface.faces.weight.ravel()
        share = arrival(-self.loading.penetration(step.start, step.before), fresh, area)
        return _Arrivals(fresh, share * (step.end - step.start), np.maximum(reach, slowest), place)

    def _corrected(
        self, each: Variation, step: IncrementTransition, old: StateDerivative, arrivals: _Arrivals
    ) -> ContactHistory:
        """Return the derivative of the history with which the increment was solved.

        Points that stuck before keep their derivative. A point in new contact at the depth d_c sticks at its place s
        there, and ``ds/dq = s_q + s_d d_c,q`` with ``d_c,q = -g_q / g_d`` of its gap g. Ahead of the edge of the
        sticking region, s_q and s_d vary as the square root of the distance from it, and the roots cancel in the sum.
        The sum is therefore computed at the last equilibria and extrapolated to the time of contact. If the obstacle
        moves only sideways and nothing slips, the sum varies as the distance to the power 1.5, since the rate of a
        free point vanishes at the edge, and is extrapolated by that law; otherwise linearly.
        """
        reach, place = self._foot_rate(each, step, old.u)
        ahead = place - (reach / arrivals.pace)[:, None] * arrivals.drift
        arrived = ahead
        if each.name in self._ahead and (step.earlier.limit > 0).any():
            earlier, then = self._ahead[each.name]
            power = _EDGE_POWER if each.sideways and np.isinf(each.above.law.friction) else 1.0
            left, made = arrivals.after**power, (arrivals.after + step.start - earlier) ** power
            arrived = ahead + (left / (made - left))[:, None] * (ahead - then)
        self._ahead[each.name] = (step.start, ahead)
        anchor = np.where(arrivals.fresh[:, None], arrived, old.history.anchor)
        high, low = (
            each.loading(side).obstacle(step.end).normal_at(step.history.anchor + side * each.step * anchor)
            for side in _SIDES
        )
        normal = np.where(arrivals.fresh[:, None], (high - low) / (2 * each.step), old.history.normal)
        return old.history._replace(anchor=anchor, normal=normal)

    def _foot_rate(self, each: Variation, step: IncrementTransition, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives of penetration (n_points,) and place (n_points, 3) at the last equilibrium."""
        feet = []
        for side in _SIDES:
            state = State(step.before.u + side * each.step * u, step.before.p)
            met = each.loading(side).contact_pair(step.start, state)
            feet.append(met.obstacle.closest_points(met.points))
        (reach1, place1), (reach0, place0) = feet
        twice = 2 * each.step
        return (reach1 - reach0) / twice, (place1 - place0) / twice

    @property
    def _path(self) -> Variation:
        """The path itself as a parameter."""
        high, low = (
            replace(self.loading, obstacle=partial(_later, self.loading.obstacle, by)) for by in (_STEP, -_STEP)
        )
        return Variation("", _STEP, high, low, lasting=False)

    def _limits(self, each: Variation, step: IncrementTransition, u: FloatArray) -> FloatArray:
        """Return the derivative (n_points,) MPa of the friction limit for that of the displacement."""
        found = []
        for side in _SIDES:
            state = State(step.after.u + side * each.step * u, step.after.p)
            found.append(each.loading(side).law.friction_limit(each.loading(side).penetration(step.end, state)))
        return np.where(step.history.limit > 0, (found[0] - found[1]) / (2 * each.step), 0.0)

    def _stored(
        self, each: Variation, step: IncrementTransition, u: FloatArray, rate: ContactHistory
    ) -> ContactHistory:
        """Return the derivative of the history after the increment."""
        found = []
        for side in _SIDES:
            by = side * each.step
            state = State(step.after.u + by * u, step.after.p)
            found.append(each.loading(side).update_history(_moved(step.history, rate, by), step.end, state)[0])
        return _difference(found[0], found[1], each.step)


def _later(obstacle: Callable[[float], Obstacle], by: float, at: float) -> Obstacle:
    return obstacle(at + by)


def _moved(history: ContactHistory, rate: ContactHistory, by: float) -> ContactHistory:
    """Return a history moved along its derivative; infinite or zero limits are unchanged."""
    slips = np.isfinite(history.limit) & (history.limit > 0)
    limit = np.where(slips, np.maximum(history.limit + by * rate.limit, np.finfo(float).tiny), history.limit)
    return history._replace(
        anchor=history.anchor + by * rate.anchor, normal=history.normal + by * rate.normal, limit=limit
    )


def _difference(high: ContactHistory, low: ContactHistory, step: float) -> ContactHistory:
    both = (high.limit > 0) & (low.limit > 0)
    with np.errstate(invalid="ignore"):
        limit = np.nan_to_num((high.limit - low.limit) / (2 * step))
    anchor = np.where(both[:, None], (high.anchor - low.anchor) / (2 * step), 0.0)
    normal = np.where(both[:, None], (high.normal - low.normal) / (2 * step), 0.0)
    return ContactHistory(anchor, normal, np.where(both, limit, 0.0), np.zeros_like(limit))
