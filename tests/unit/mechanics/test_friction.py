"""Stick and slip of one point under a wall that is dragged along: Coulomb's law in closed form."""

import numpy as np
import pytest

from palpate.fea import Ball, Plane
from palpate.mechanics import ContactLaw
from palpate.mechanics.friction import ContactPair, correct_history, dissipated, empty_history, return_to_limit

UP = np.array([0.0, 0.0, 1.0])
LAW = ContactLaw(stiffness=10.0, width=1e-6, tangential_stiffness=5.0, friction=0.4)
DEEP = 0.1


def wall(along: float) -> Plane:
    return Plane(UP, np.array([along, 0.0, 0.0]))


def point(reach: float, along: float = 0.0) -> np.ndarray:
    return np.array([[along, 0.0, reach]])


def touched(law: ContactLaw = LAW) -> tuple[ContactPair, object]:
    """A point that came to touch straight on, and its history."""
    before, after = ContactPair(point(-DEEP), wall(0.0)), ContactPair(point(DEEP), wall(0.0))
    return after, return_to_limit(law, correct_history(law, empty_history(1), before, after, np.ones(1)), after)


def test_points_that_touch_anew_stick_in_the_order_in_which_they_were_near() -> None:
    before = ContactPair(np.concatenate([point(-1.0), point(-2.0)]), wall(0.0))
    after = ContactPair(np.concatenate([point(3.0, 4.0), point(3.0, 4.0)]), wall(0.0))
    history = correct_history(LAW, empty_history(2), before, after, np.array([1.0, 3.0]))
    assert history.anchor == pytest.approx(np.array([[0.5, 0, 0], [2.5, 0, 0]]))  # in the middle of their areas
    assert history.limit == pytest.approx(LAW.friction * LAW.stiffness * 3.0, rel=1e-5)


def test_beside_what_sticks_a_point_slides_two_thirds_as_far() -> None:
    sticking = empty_history(2)._replace(limit=np.array([np.inf, 0.0]), anchor=np.array([[7.0, 0, 0], [0, 0, 0]]))
    before = ContactPair(np.concatenate([point(0.1, 7.0), point(-2.0)]), wall(0.0))
    after = ContactPair(np.concatenate([point(0.1, 7.0), point(3.0, 4.0)]), wall(0.0))
    history = correct_history(LAW, sticking, before, after, np.ones(2))
    assert history.anchor == pytest.approx(np.array([[7.0, 0, 0], [4.0 * 0.5 * 2 / 3, 0, 0]]))


def test_sticking_places_converge_to_the_path_of_a_crack_front() -> None:
    """Points at x move as the root of the distance from a front that sweeps on: they stick where it reaches them."""
    x, area = (np.arange(200) + 0.5) / 200, np.full(200, 1 / 200)
    times = np.linspace(0, 1, 20001)
    exact = np.trapezoid(np.sqrt(np.maximum(x[:, None] - times, 0.0)), times, axis=1)
    before = ContactPair(np.column_stack([x, 0 * x, -x]), wall(0.0))
    after = ContactPair(np.column_stack([x + np.sqrt(x), 0 * x, 0 * x + 0.1]), wall(0.0))
    stuck = empty_history(201)._replace(limit=np.r_[np.zeros(200), np.inf])
    far = np.array([[-1.0, 0.0, 0.1]])
    before, after = (ContactPair(np.concatenate([met.points, far]), met.obstacle) for met in (before, after))
    history = correct_history(LAW, stuck, before, after, np.r_[area, 1.0])
    assert history.anchor[:200, 0] - x == pytest.approx(exact, abs=1e-4)


def test_a_dragged_point_sticks_up_to_the_limit_and_then_slips() -> None:
    _, history = touched()
    limit = LAW.friction * LAW.stiffness * DEEP
    most = limit / LAW.tangential_stiffness
    for drag in (0.5 * most, 0.99 * most):
        kept = return_to_limit(LAW, history, ContactPair(point(DEEP), wall(drag)))
        assert kept.anchor[0] == pytest.approx(history.anchor[0], abs=1e-12)
        assert dissipated(LAW, history, ContactPair(point(DEEP), wall(drag)), np.ones(1)) == 0.0
    drag = 3.0 * most
    slipped = return_to_limit(LAW, history, ContactPair(point(DEEP), wall(drag)))
    spring = -drag - slipped.anchor[0, 0]
    assert abs(spring) * LAW.tangential_stiffness == pytest.approx(limit, rel=1e-5)
    lost = dissipated(LAW, history, ContactPair(point(DEEP), wall(drag)), np.ones(1))
    assert lost == pytest.approx(limit * (drag - most), rel=1e-5)


def test_a_point_that_lifts_sticks_no_more() -> None:
    _, history = touched()
    lifted = return_to_limit(LAW, history, ContactPair(point(-DEEP), wall(0.0)))
    assert lifted.limit[0] == 0.0


@pytest.mark.parametrize(("friction", "limit"), [(0.0, 0.0), (np.inf, np.inf)])
def test_no_friction_and_no_slip_are_the_ends_of_the_law(friction: float, limit: float) -> None:
    law = LAW._replace(friction=friction)
    met, history = touched(law)
    assert history.limit[0] == limit
    assert dissipated(law, history, met, np.ones(1)) == 0.0


def test_on_a_ball_the_sticking_place_goes_with_the_ball() -> None:
    ball = Ball(5.0, np.array([0.0, 0.0, 5.0]))
    before, after = ContactPair(point(-DEEP), ball), ContactPair(point(DEEP), ball)
    history = return_to_limit(LAW, correct_history(LAW, empty_history(1), before, after, np.ones(1)), after)
    assert history.anchor[0] == pytest.approx([0.0, 0.0, -5.0], abs=1e-12)
    assert history.normal[0] == pytest.approx(UP)
