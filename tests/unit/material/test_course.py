"""Walls through time on robots of every kind, against closed forms of a linear spring and a standard solid."""

import numpy as np
import pytest

from errors import refused
from palpate.material import (
    ForceCurve,
    Moduli,
    Relaxation,
    relax_history,
    simulate_compliant_hold,
    simulate_depth_hold,
    simulate_force_hold,
)

LOST, TIME, SPRING = 0.3, 4.0, 0.5
SOLID = Relaxation((LOST,), (TIME,), Moduli.INSTANTANEOUS)
CURVE = ForceCurve(np.array([0.0, 20.0]), np.array([0.0, 20.0 * SPRING]))
LATER = np.concatenate([[0.0], np.geomspace(1e-3, 60, 400)])


def test_a_wall_held_relaxes_and_a_bent_curve_is_followed_exactly():
    """A ramp over a curve with corners is the same as the same ramp cut at the corners by hand."""
    curve = ForceCurve(np.array([0.0, 1.0, 3.0, 8.0]), np.array([0.0, 0.1, 0.6, 3.0]))
    found = simulate_depth_hold(SOLID, curve, np.array([0.0, 4.0, 30.0]), np.array([0.0, 8.0, 8.0]))
    by_hand = relax_history(SOLID, np.array([0.0, 0.5, 1.5, 4.0, 30.0]), np.array([0.0, 0.1, 0.6, 3.0, 3.0]))
    assert found.force == pytest.approx(by_hand[[0, 3, 4]], rel=1e-12)


def test_a_wall_drawn_back_through_corners_is_followed_exactly():
    curve = ForceCurve(np.array([0.0, 1.0, 3.0]), np.array([0.0, 0.1, 0.6]))
    found = simulate_depth_hold(SOLID, curve, np.array([0.0, 2.0]), np.array([3.0, 0.0]))
    by_hand = relax_history(SOLID, np.array([0.0, 4 / 3, 2.0]), np.array([0.6, 0.1, 0.0]))
    assert found.force[-1] == pytest.approx(by_hand[-1], rel=1e-12)


def test_forces_of_three_components_are_followed():
    curve = ForceCurve(np.array([0.0, 1.0]), np.array([[0.0, 0, 0], [0.1, -0.2, 1.0]]))
    found = simulate_depth_hold(SOLID, curve, np.array([0.0, 5.0]), np.array([1.0, 1.0]))
    assert found.force[1] == pytest.approx(float(SOLID.relaxation_function(5.0)) * curve.force[1], rel=1e-12)


def test_under_a_kept_force_a_standard_solid_creeps_as_known():
    """Creep compliance of one decay: ``(1 - g exp(-(1 - g) t / T)) / ((1 - g) k)`` (Tschoegl 1989, section 3.4)."""
    found = simulate_force_hold(SOLID, CURVE, LATER, np.full(len(LATER), 2.0))
    exact = 2.0 / SPRING * (1 - LOST * np.exp(-(1 - LOST) * LATER / TIME)) / (1 - LOST)
    assert found.depth == pytest.approx(exact, rel=2e-4)
    assert found.force == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize("stiffness", [0.05, 1.0, 50.0])
def test_on_a_robot_that_gives_way_the_wall_sinks_as_known(stiffness):
    """A spring and a standard solid in a row: one decay, from the ratio of stiffnesses at first to that at last."""
    found = simulate_compliant_hold(SOLID, CURVE, LATER, np.full(len(LATER), 8.0), stiffness)
    first, last = 8 * stiffness / (stiffness + SPRING), 8 * stiffness / (stiffness + (1 - LOST) * SPRING)
    rate = (stiffness + (1 - LOST) * SPRING) / (stiffness + SPRING) / TIME
    assert found.depth == pytest.approx(last + (first - last) * np.exp(-rate * LATER), rel=2e-4)
    assert found.force == pytest.approx(stiffness * (8 - found.depth), rel=1e-9)


def test_a_stiff_robot_holds_the_wall():
    sunk = simulate_compliant_hold(SOLID, CURVE, LATER, np.full(len(LATER), 8.0), 1e7)
    held = simulate_depth_hold(SOLID, CURVE, LATER, np.full(len(LATER), 8.0))
    assert sunk.force == pytest.approx(held.force, rel=1e-6)


def test_a_wall_that_creeps_beyond_the_press_is_refused():
    with refused("press-curve-too-short", "0", "20"):
        simulate_force_hold(SOLID, CURVE, LATER, np.full(len(LATER), 11.0))
    with refused("press-curve-too-short", "21", "20"):
        simulate_depth_hold(SOLID, CURVE, np.array([0.0, 1.0]), np.array([0.0, 21.0]))
    with refused("robot-stiffness-not-positive", "0"):
        simulate_compliant_hold(SOLID, CURVE, LATER, LATER, 0.0)


def test_what_is_no_curve_or_no_course_is_refused():
    with refused("press-curve-malformed"):
        ForceCurve(np.array([0.0, 1.0, 0.5]), np.array([0.0, 1.0, 0.4]))
    with refused("press-curve-malformed", "2", "3"):
        ForceCurve(np.array([0.0, 1.0]), np.zeros(3))
    with refused("course-lengths-differ", "2", "3"):
        simulate_depth_hold(SOLID, CURVE, np.array([0.0, 1.0]), np.zeros(3))
    with refused("press-curve-missing"):
        simulate_force_hold(SOLID, ForceCurve(CURVE.depth, np.zeros((2, 3))), LATER, LATER)
