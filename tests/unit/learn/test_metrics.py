import numpy as np
import pytest

from errors import refused
from palpate.learn import ErrorSummary, Metrics, measure_errors


def test_summary_agrees_with_a_vector_worked_by_hand():
    summary = ErrorSummary.of(np.array([1.0, -1.0, 3.0, 1.0]))
    assert summary.rmse == pytest.approx(np.sqrt(3.0))
    assert summary.mae == 1.5
    assert summary.max == 3.0
    assert summary.bias == 1.0
    assert summary.sd == pytest.approx(np.sqrt(2.0))


def test_square_of_rmse_is_bias_and_spread_and_the_three_are_ordered():
    errors = np.random.default_rng(1).normal(0.4, 2.0, 500)
    summary = ErrorSummary.of(errors)
    assert summary.rmse**2 == pytest.approx(summary.bias**2 + summary.sd**2)
    assert summary.max >= summary.rmse >= summary.mae


def test_angle_pools_both_components_and_leaves_the_depth_out():
    poses = np.zeros((2, 3))
    estimates = np.array([[3.0, 4.0, 100.0], [0.0, 0.0, -100.0]])
    metrics = measure_errors(estimates, poses)
    assert metrics.rmse_deg == pytest.approx(np.sqrt(25 / 4))
    assert metrics.max_error_deg == 4.0
    assert metrics.by_axis["rx"].max == 3.0
    assert metrics.by_axis["depth"].rmse == 100.0


def test_errors_are_sorted_by_true_depth():
    poses = np.array([[0, 0, 4.8], [0, 0, 2.4], [0, 0, 2.4]])
    estimates = poses + np.array([[0.1, 0.1, 0], [2, 0, 0], [0, 0, 0]])
    shallow, deep = measure_errors(estimates, poses).by_depth
    assert (shallow.depth_mm, shallow.images, deep.depth_mm, deep.images) == (2.4, 2, 4.8, 1)
    assert shallow.pooled.rmse == pytest.approx(1.0)
    assert deep.pooled.max == pytest.approx(0.1)


def test_an_estimate_that_is_not_a_number_is_refused():
    with refused("estimates-not-finite", "1", "2"):
        measure_errors(np.array([[0, 0, np.nan], [0, 0, 1.0]]), np.zeros((2, 3)))


def test_no_image_is_refused():
    with refused("evaluation-no-image"):
        measure_errors(np.zeros((0, 3)), np.zeros((0, 3)))


def test_metrics_survive_json():
    rng = np.random.default_rng(0)
    metrics = measure_errors(rng.normal(size=(6, 3)), np.repeat([[0, 0, 1.0], [1, 0, 2.0]], 3, axis=0))
    assert Metrics.from_dict(metrics.as_dict()) == metrics


def test_errors_are_sorted_into_intervals_of_true_tilt():
    poses = np.array([[0, 0, 2.4], [0, 1.9, 2.4], [2.0, 0, 2.4], [0, -11.0, 2.4], [12.0, 0, 2.4]])
    estimates = poses + np.array([[1, 1, 0], [1, 1, 0], [3, 3, 0], [2, 2, 0], [2, 2, 0]])
    found = [
        (part.from_deg, part.to_deg, part.images, part.pooled.rmse)
        for part in measure_errors(estimates, poses).by_tilt
    ]
    assert found == [(0, 2, 2, pytest.approx(1)), (2, 4, 1, pytest.approx(3)), (10, 12, 2, pytest.approx(2))]


def test_straight_presses_alone_are_one_interval():
    (only,) = measure_errors(np.ones((2, 3)), np.zeros((2, 3))).by_tilt
    assert (only.from_deg, only.to_deg, only.images) == (0, 2, 2)
