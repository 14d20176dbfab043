"""Derivatives of a path with respect to what it was made with: one back-substitution each.

In equilibrium the residual vanishes, ``r(u, q, h) = 0``, for every value of a parameter q. So the field's derivative
follows from the tangent K that Newton's method leaves behind,

    K du/dq = - dr/dq - (dr/dh) dh/dq,

where the history h (sticking places and limits) has a derivative of its own, carried from increment to increment by
the derivative of the rules that carry the history itself (Michaleris, Tortorelli & Vidal, *Int. J. Numer. Meth.
Eng.* 37, 1994: direct differentiation of transient problems). The explicit derivatives on the right are central
differences of one assembly, of residuals and of the rules of contact, at a state that stands still: exact to
rounding, and no law, obstacle or skin need give any. Where the limit of friction follows the pressure, the tangent is
that of Newton's method, which holds the limit, and the rest is iterated.

With half a body, a parameter may break the mirror symmetry. The derivative is then antisymmetric: it is solved by a
body of the same cells whose mirror plane holds what the other lets go (`Across`).
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
_STEP = 1e-5
"""Half the difference of the path's own parameter, mm."""
_SLOWEST = 0.02
"""Least pace at which a point nears the obstacle, over the greatest, for which its delay is its own."""
_EDGE_POWER = 1.5
"""Power of the distance from what sticks, as which the derivative of a free point's place leaves that at the edge."""
_LIMIT_ROUNDS = 3
"""Rounds in which the limit of friction follows the derivative of the pressure."""


@dataclass(frozen=True)
class Variation:
    """A parameter, and what the path is made of where it is a little greater and a little smaller.

    Attributes
    ----------
    name
        Of the parameter.
    step
        Half the difference of the two, in the unit of the parameter: small, for displacement and history are moved
        by as much along their derivatives.
    above, below
        What presses with the parameter greater and smaller.
    solids
        The body likewise; None where the parameter leaves it alone.
    lasting
        Whether the parameter has been different since rest; otherwise it changes at the increment alone.
    antisymmetric
        Whether it breaks the mirror symmetry of half a body.
    sideways
        Whether it moves the obstacle in its own surface alone, so that no point is reached sooner or later for it.
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
        """What presses with the parameter greater (1) or smaller (-1)."""
        return self.above if side > 0 else self.below


class StateDerivative(NamedTuple):
    """Derivative by one parameter: displacement (n, 3) mm, force (3,) N of the modelled part, and history."""

    u: FloatArray
    force: FloatArray
    history: ContactHistory


class IncrementTransition(NamedTuple):
    """An increment whose derivative is sought.

    Attributes
    ----------
    number
        Of the increment in the path; that at rest is 0.
    start, end
        Parameter of the path before and after, mm.
    before, after
        Equilibria: the last, and the one reached.
    earlier, history
        What contact remembers of the last, and with which the increment was solved.
    """

    number: int
    start: float
    end: float
    before: State
    after: State
    earlier: ContactHistory
    history: ContactHistory


class _Arrivals(NamedTuple):
    """Points that touch anew: which (n,), how far on the path (n,) mm, pace (n,) and drift (n, 3) beforehand.

    Pace is the growth of the penetration, drift that of the place on the obstacle, both over the path's parameter.
    """

    fresh: BoolArray
    after: FloatArray
    pace: FloatArray
    drift: FloatArray


@dataclass
class Sensitivity:
    """Follows derivatives along a path.

    Attributes
    ----------
    problem, loading
        Body with linear solver, and what presses, of the path.
    variations
        The parameters.
    across
        The same body with its mirror plane held antisymmetrically; needed where a variation is `across`.
    rates
        Derivative at the last increment, by name.
    found
        Derivatives of every increment asked for, by its number in the path: rates by name.
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
        """Take an equilibrium of the path by itself, where contact remembers nothing."""
        self.start(history)
        self.accept(IncrementTransition(number, at, at, state, state, history, history), memory=False, asked=True)

    def accept(self, step: IncrementTransition, *, memory: bool, asked: bool) -> None:
        """Take an increment: with `memory`, also the derivatives of the history that it leaves.

        Where it is not `asked` for, only what goes on is computed: no force, and nothing that changes there alone.
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
        """Derivative (n, 3) mm of the displacement for that of the history."""
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
        """Residual (3 n,) N of the state at the end of a step, or of that moved along `u`, and the force (3,) N."""
        loading, by = each.loading(side), side * each.step
        own = self.problem.assembly
        to = own._replace(nodes=loading.nodes, system=System(own.system.data, np.zeros(own.nodes.size)))
        state = step.after if u is None else State(step.after.u + by * u, step.after.p)
        if each.solids is not None and u is None:
            each.solids[0 if side > 0 else 1].add_residual(state, to.system.residual)
        share = loading.contact(step.end, _moved(step.history, rate, by)).add_residual(state, to)
        return to.system.residual, share.force

    def _arrive(self, step: IncrementTransition) -> _Arrivals:
        """Which points touch anew in an increment, when, and how fast they were on their way."""
        fresh = (step.earlier.limit == 0) & (step.history.limit > 0)
        reach, place = self._foot_rate(self._path, step, self._pace)
        slowest = _SLOWEST * float(np.abs(reach[fresh] if fresh.any() else reach).max())
        area = self.loading.surface.faces.weight.ravel()
        share = arrival(-self.loading.penetration(step.start, step.before), fresh, area)
        return _Arrivals(fresh, share * (step.end - step.start), np.maximum(reach, slowest), place)

    def _corrected(
        self, each: Variation, step: IncrementTransition, old: StateDerivative, arrivals: _Arrivals
    ) -> ContactHistory:
        """Derivative of the history with which the increment was solved.

        What stuck before goes on. A point that touches anew at the depth d_c sticks at its place s there, and
        ``ds/dq = s_q + s_d d_c,q`` with ``d_c,q = -g_q / g_d`` of its gap g. Ahead of the edge of what sticks, s_q
        and s_d go as the root of the distance from it, and in the sum the roots cancel: so it is taken at the last
        equilibria and carried on to the share of the increment at which the point is reached. Where the obstacle
        moves sideways alone and nothing slips, what is left goes as the distance to the power 1.5, for the rate of a
        free point vanishes at the edge, and is carried on by that law; otherwise straight.
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
        """Derivatives of penetration (n_points,) and place (n_points, 3) at the last equilibrium."""
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
        """Derivative (n_points,) MPa of the limit of friction for that of the displacement."""
        found = []
        for side in _SIDES:
            state = State(step.after.u + side * each.step * u, step.after.p)
            found.append(each.loading(side).law.friction_limit(each.loading(side).penetration(step.end, state)))
        return np.where(step.history.limit > 0, (found[0] - found[1]) / (2 * each.step), 0.0)

    def _stored(
        self, each: Variation, step: IncrementTransition, u: FloatArray, rate: ContactHistory
    ) -> ContactHistory:
        """Derivative of the history that the increment leaves."""
        found = []
        for side in _SIDES:
            by = side * each.step
            state = State(step.after.u + by * u, step.after.p)
            found.append(each.loading(side).update_history(_moved(step.history, rate, by), step.end, state)[0])
        return _difference(found[0], found[1], each.step)


def _later(obstacle: Callable[[float], Obstacle], by: float, at: float) -> Obstacle:
    return obstacle(at + by)


def _moved(history: ContactHistory, rate: ContactHistory, by: float) -> ContactHistory:
    """A history moved along its derivative; what is infinite or zero stays."""
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
