import time

import numpy as np
import pytest

from errors import refused
from kinematic_press import KinematicPress, kinematic_positions, rings, solved
from palpate.surrogate import build_field

LAYOUT = rings()
DEEPEST = 9


def direct(rx, ry, depth):
    return kinematic_positions(LAYOUT.positions, rx, ry, depth)


@pytest.mark.parametrize(("rx", "ry"), [(0.0, 0.0), (5.0, 0.0), (0.0, 7.0), (-3.1, 4.2), (-8.0, -8.5), (11.5, -2.0)])
def test_any_pose_agrees_with_the_direct_solution(rx, ry):
    field = build_field(solved(), LAYOUT)
    found = field.positions(np.array([rx]), np.array([ry]), DEEPEST)[0]
    assert np.abs(found - direct(rx, ry, 8.0)).max() < 2e-5


def test_error_of_the_tilt_spline_falls_with_the_fourth_power_of_the_step():
    errors = []
    for step in (4, 2, 1):
        field = build_field(solved(range(0, 13, step)), LAYOUT)
        tilts = np.linspace(0, 12, 121)
        found = field.positions(tilts, np.zeros(121), DEEPEST)
        errors.append(max(np.abs(a - direct(t, 0, 8.0)).max() for a, t in zip(found, tilts, strict=True)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates.min() > 3.5


def test_presses_at_another_azimuth_give_the_same_field():
    one = build_field(solved(), LAYOUT)
    other = build_field(solved(azimuth_deg=70.0), LAYOUT)
    rx, ry = np.array([3.0, -6.0]), np.array([1.0, 5.0])
    assert np.abs(one.positions(rx, ry, 5) - other.positions(rx, ry, 5)).max() < 1e-9


def test_opposite_walls_mirror_each_other():
    field = build_field(solved(), LAYOUT)
    there, back = field.positions(np.array([4.0, -4.0]), np.zeros(2), DEEPEST)
    mirrored = np.abs(there[:, None, :] * [1, -1, 1] - back[None]).max(axis=2).min(axis=1)
    assert mirrored.max() < 1e-9


def test_each_free_marker_gets_its_own_circle():
    rng = np.random.default_rng(2)
    flat = rng.uniform(-12, 12, (9, 2))
    layout = rings()
    layout.positions = np.column_stack([flat, np.sqrt(400 - (flat**2).sum(axis=1))])
    field = build_field(solved(), layout)
    found = field.positions(np.array([2.5]), np.array([6.0]), DEEPEST)[0]
    assert np.abs(found - kinematic_positions(layout.positions, 2.5, 6.0, 8.0)).max() < 2e-5


def presses_that_snap():
    """Tilts 0 … 6° stay flat, 8 … 12° are inverted from 4 mm on."""
    return solved(range(0, 7, 2)) + solved(range(8, 13, 2), inverted_from=4.0)


def test_nothing_is_interpolated_between_two_branches():
    field = build_field(presses_that_snap(), LAYOUT)
    branch, reason = field.labels(np.array([5.9, 6.0, 7.0, 8.0, 9.0]), DEEPEST)
    assert list(branch) == ["flat", "flat", "", "inverted", "inverted"]
    assert reason[2] == "between the flat and the inverted branch"
    assert np.isnan(field.positions(np.array([7.0]), np.zeros(1), DEEPEST)).all()
    assert list(field.labels(np.array([7.0]), 2)[0]) == ["flat"]


def test_a_run_is_not_disturbed_by_its_neighbour_on_the_other_branch():
    field = build_field(presses_that_snap(), LAYOUT)
    alone = build_field(solved(range(0, 7, 2)), LAYOUT)
    args = (np.array([5.3]), np.array([1.0]), DEEPEST)
    assert np.array_equal(field.positions(*args), alone.positions(*args))
    inverted = field.positions(np.array([9.0]), np.zeros(1), DEEPEST)[0]
    assert np.abs(inverted - kinematic_positions(LAYOUT.positions, 9.0, 0, 8.0, inverted=True)).max() < 5e-3


def test_a_depth_not_reached_by_a_tilt_is_not_extrapolated():
    presses = [*solved(range(0, 9, 2)), *solved((10, 12), reached=7.1, ended="wall reached the clamped rim")]
    field = build_field(presses, LAYOUT)
    branch, reason = field.labels(np.array([8.0, 8.5, 11.0]), DEEPEST)
    assert list(branch) == ["flat", "", ""]
    assert list(reason[1:]) == ["wall reached the clamped rim"] * 2
    assert list(field.labels(np.array([11.0]), 7)[0]) == ["flat"]


def test_a_lone_tilt_answers_for_itself_alone():
    presses = [*solved(range(0, 11, 2)), KinematicPress(12.0, inverted_from=4.0)]
    field = build_field(presses, LAYOUT)
    assert list(field.labels(np.array([11.9, 12.0]), DEEPEST)[0]) == ["", "inverted"]
    found = field.positions(np.array([12.0]), np.zeros(1), DEEPEST)[0]
    assert np.abs(found - kinematic_positions(LAYOUT.positions, 12.0, 0, 8.0, inverted=True)).max() < 1e-6


def test_tilts_beyond_the_last_press_have_a_reason():
    field = build_field(solved(range(0, 9, 2)), LAYOUT)
    assert list(field.labels(np.array([9.0]), 3)[1]) == ["beyond the solved tilts"]


def test_thousands_of_poses_of_169_markers_take_less_than_two_seconds():
    field = build_field(solved(), rings((5, 10, 15, 20, 25, 30, 35)))
    rng = np.random.default_rng(0)
    start = time.process_time()
    found = field.positions(rng.uniform(-8, 8, 4000), rng.uniform(-8, 8, 4000), 4)
    assert found.shape == (4000, 169, 3)
    assert time.process_time() - start < 2.0


def test_presses_that_do_not_belong_together_are_refused():
    with refused("tilt-twice"):
        build_field([KinematicPress(2.0), KinematicPress(2.0)], LAYOUT)
    with refused("presses-none"):
        build_field([], LAYOUT)
    other = KinematicPress(4.0)
    other.obstacle.depth_step = 0.4
    with refused("presses-steps-differ", "0.4"):
        build_field([KinematicPress(2.0), other], LAYOUT)


def test_a_marker_outside_the_dome_is_refused():
    layout = rings()
    layout.positions[3, 2] = np.nan
    with refused("markers-outside-skin", "1"):
        build_field(solved(), layout)
