"""The heart of the solver alone: a branch, its limit point and its jump on a von Mises truss with a closed form."""

from dataclasses import replace

import numpy as np
import pytest

from palpate.core import FloatArray
from palpate.mechanics import (
    Continuation,
    DeadLoad,
    DeadLoading,
    EndReason,
    NullMonitor,
    Problem,
    SolverSpec,
    State,
    make_linear_solver,
)
from palpate.mechanics.friction import ContactHistory, empty_history
from palpate.mechanics.linear import Pattern
from palpate.mechanics.loading import PathLoading
from palpate.mechanics.solid import Body
from palpate.mechanics.term import Term
from validation.arc_length import ArcLength

HALF_SPAN, RISE, STIFFNESS = 10.0, 1.0, 2000.0


class Truss(Body):
    """Two bars that meet in an apex; ``E = k (z² - h²)² / (4 L³)``-like energy, shallow bars (von Mises 1923).

    With the height z of the apex, each bar's Green strain is ``(z² - h²) / (2 L²)``: force along z
    ``k z (z² - h²) / L³``, limit points at ``z = ± h / sqrt(3)`` under ``2 k h³ / (3 sqrt(3) L³)``.
    """

    nodes = np.array([[0.0, 0.0, RISE]])
    free = np.array([2])
    pattern = Pattern(np.array([0, 1]), np.array([0]))
    place = np.empty((0, 3321), np.int64)
    nodal_volume = np.ones(1)
    shear_modulus = STIFFNESS / HALF_SPAN**3

    def rest(self) -> State:
        return State(np.zeros((1, 3)), np.zeros((0, 4)))

    def add_residual(self, state: State, residual: FloatArray) -> float:
        z = RISE + state.u[0, 2]
        scale = STIFFNESS / HALF_SPAN**3
        residual[2] += scale * z * (z**2 - RISE**2)
        return scale * (z**2 - RISE**2) ** 2 / 4

    def add_tangent(self, state: State, data: FloatArray) -> None:
        data[0] += STIFFNESS / HALF_SPAN**3 * (3 * (RISE + state.u[0, 2]) ** 2 - RISE**2)

    def recover_pressure(self, du: FloatArray) -> FloatArray:
        return np.zeros((0, 4))


LIMIT = STIFFNESS / HALF_SPAN**3 * 2 * RISE**3 / (3 * np.sqrt(3))


def follow(jumps: bool) -> Continuation:
    problem = Problem(Truss(), make_linear_solver("superlu"), 1e-10, RISE)
    spec = SolverSpec(first_step=0.05, largest_step=0.1, smallest_step=1e-3)
    down = DeadLoad(np.array([[0.0, 0.0, -1.0]]))
    return Continuation(problem, DeadLoading(down), NullMonitor(), spec, unit=LIMIT, jumps=jumps)


def height(path: Continuation) -> float:
    return RISE + path.last.state.u[0, 2]


def test_a_branch_is_followed_to_its_limit_point() -> None:
    path = follow(jumps=False)
    assert not path.advance(2 * LIMIT)
    assert path.ended is EndReason.BRANCH_ENDED
    assert path.last.depth == pytest.approx(LIMIT, rel=2e-3)
    assert height(path) == pytest.approx(RISE / np.sqrt(3), rel=0.05)


def test_every_increment_is_an_equilibrium_and_the_work_is_stored() -> None:
    path = follow(jumps=False)
    path.advance(0.9 * LIMIT)
    for increment in path.increments:
        z = RISE + increment.state.u[0, 2]
        assert STIFFNESS / HALF_SPAN**3 * z * (RISE**2 - z**2) == pytest.approx(increment.depth, abs=1e-8)
        assert increment.loads.elastic == pytest.approx(STIFFNESS / HALF_SPAN**3 * (z**2 - RISE**2) ** 2 / 4)


def test_past_the_limit_point_the_truss_snaps_through_and_goes_on() -> None:
    path = follow(jumps=True)
    assert path.advance(2 * LIMIT)
    jumped = [increment for increment in path.increments if increment.jumped]
    assert len(jumped) == 1
    assert jumped[0].depth == pytest.approx(LIMIT, rel=0.03)
    roots = np.roots([1.0, 0.0, -(RISE**2), 2 * LIMIT / (STIFFNESS / HALF_SPAN**3)])
    assert height(path) == pytest.approx(roots[np.isreal(roots)].real[0], abs=1e-8)
    assert height(path) < -RISE


def test_an_increment_that_leads_elsewhere_is_cut_back() -> None:
    """A first increment far beyond the limit point lands on the other branch: energy gained is not work done."""
    problem = Problem(Truss(), make_linear_solver("superlu"), 1e-10, RISE)
    spec = SolverSpec(first_step=10.0, largest_step=10.0, smallest_step=1e-3)
    down = DeadLoad(np.array([[0.0, 0.0, -1.0]]))
    path = Continuation(problem, DeadLoading(down), NullMonitor(), spec, unit=LIMIT, jumps=False)
    for share in (0.2, 0.4, 0.6):
        assert path.advance(share * LIMIT)
    assert not path.advance(2 * LIMIT)
    assert path.last.depth == pytest.approx(LIMIT, rel=0.02)
    assert height(path) > 0


class Sliding(PathLoading):
    """A load whose traction limits never agree with the solution: each correction doubles them."""

    remembers = True

    def __init__(self) -> None:
        self.load, self.corrections = DeadLoad(np.array([[0.0, 0.0, -1.0]])), 0

    def max_increment(self, at: float, edge: float, radius: float) -> float:
        return np.inf

    def start(self) -> ContactHistory:
        return empty_history(1)._replace(limit=np.ones(1))

    def terms(self, at: float, history: ContactHistory) -> tuple[Term, ...]:
        return (replace(self.load, factor=at),)

    def stuck_terms(self, at: float, last: float, state: State, history: ContactHistory) -> tuple[Term, ...]:
        return self.terms(at, history)

    def correct(self, history: ContactHistory, *ends: tuple[float, State]) -> ContactHistory:
        self.corrections += 1
        assert self.corrections < 100, "passes without end"
        return history._replace(limit=2.0 * history.limit)

    def update_history(self, history: ContactHistory, at: float, state: State) -> tuple[ContactHistory, float]:
        return self.start(), 0.0


def test_a_history_that_never_agrees_is_corrected_four_times_an_increment() -> None:
    problem, loading = Problem(Truss(), make_linear_solver("superlu"), 1e-10, RISE), Sliding()
    spec = SolverSpec(first_step=0.05, largest_step=0.05, smallest_step=1e-3)
    path = Continuation(problem, loading, NullMonitor(), spec, unit=LIMIT, jumps=False)
    assert path.advance(0.04 * LIMIT)
    assert loading.corrections == 4 * (len(path.increments) - 1)


def test_by_arc_length_the_truss_is_followed_through_both_limit_points() -> None:
    problem = Problem(Truss(), make_linear_solver("superlu"), 1e-10, RISE)
    path = ArcLength(problem, np.array([[0.0, 0.0, -1.0]]), step=0.02, longest=0.03)
    while path.points[-1].state.u[0, 2] > -2.3 * RISE:
        path.advance()
    z = RISE + np.array([point.state.u[0, 2] for point in path.points])
    load = np.array([point.factor for point in path.points])
    assert load == pytest.approx(STIFFNESS / HALF_SPAN**3 * z * (RISE**2 - z**2), abs=1e-9)
    assert (np.diff(z) < 0).all()
    inside = np.abs(z) < RISE
    assert [load[inside].max(), load[inside].min()] == pytest.approx([LIMIT, -LIMIT], rel=2e-3)
