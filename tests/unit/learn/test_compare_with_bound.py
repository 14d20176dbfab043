import numpy as np
import pytest

from errors import check_values
from palpate.datasets import DatasetSpec
from palpate.learn import ErrorBound, compare_with_bound, find_leakage, measure_errors, pool_bounds


def make_limit(depth_mm, least_squares_deg=1.0, share=1.0):
    return ErrorBound(
        depth_mm=depth_mm,
        poses=40,
        share=share,
        least_squares_deg=least_squares_deg,
        least_squares_depth_mm=0.1,
        pitman_deg=0.5 * least_squares_deg,
        pitman_error_deg=0.01,
        floor_deg=0.3 * least_squares_deg,
        floor_error_deg=0.01,
    )


def errors_of(sizes, images=400):
    """Errors whose RMSE at each depth is exactly as given."""
    depths = np.repeat(list(sizes), images)
    poses = np.column_stack([np.zeros((len(depths), 2)), depths])
    signs = np.where(np.arange(len(depths)) % 2, 1.0, -1.0)
    wrong = np.repeat(list(sizes.values()), images) * signs
    return measure_errors(poses + np.column_stack([wrong, wrong, np.zeros(len(depths))]), poses)


def test_pooling_is_a_root_mean_square_by_images_or_share():
    limits = (make_limit(2.4, 3.0, share=1.0), make_limit(4.8, 1.0, share=0.5))
    assert pool_bounds(limits).least_squares_deg == pytest.approx(np.sqrt((9 + 0.5) / 1.5))
    pooled = pool_bounds(limits, {2.4: 10, 4.8: 30})
    assert pooled.least_squares_deg == pytest.approx(np.sqrt((90 + 30) / 40))
    assert pooled.pitman_deg == pytest.approx(pooled.least_squares_deg / 2)
    assert pool_bounds(()) is None
    assert pool_bounds(limits, {8.0: 3}) is None


def test_ratio_is_that_of_rmse_and_limit_over_the_same_images():
    limits = (make_limit(2.4, 3.0), make_limit(4.8, 1.0))
    metrics = errors_of({2.4: 3.3, 4.8: 1.1})
    pooled, ratio = compare_with_bound(metrics, limits)
    assert ratio == pytest.approx(1.1)
    assert ratio == pytest.approx(metrics.rmse_deg / pooled.least_squares_deg)


def test_depths_without_a_limit_do_not_count():
    metrics = errors_of({2.4: 3.0, 4.8: 1.1})
    pooled, ratio = compare_with_bound(metrics, (make_limit(4.8, 1.0),))
    assert (pooled.least_squares_deg, ratio) == (pytest.approx(1.0), pytest.approx(1.1))
    assert compare_with_bound(metrics, ()) is None
    assert compare_with_bound(metrics, (make_limit(4.8, 0.0),)) is None


def test_an_error_below_the_floor_is_leakage():
    limits = (make_limit(2.4, 3.0), make_limit(4.8, 1.0))
    leak = find_leakage(errors_of({2.4: 3.0, 4.8: 0.2}), limits, DatasetSpec())
    check_values(leak, "4.8 mm", "0.2°")


def test_an_error_between_floor_and_limit_is_none():
    assert (
        find_leakage(errors_of({2.4: 1.0, 4.8: 0.31}), (make_limit(2.4, 3.0), make_limit(4.8)), DatasetSpec()) == ""
    )


def test_few_images_accuse_nobody():
    limits = (make_limit(4.8, 1.0),)
    assert find_leakage(errors_of({4.8: 0.25}, images=4), limits, DatasetSpec()) == ""
    assert find_leakage(errors_of({4.8: 0.2}, images=4000), limits, DatasetSpec()) != ""


def test_the_papers_repeated_poses_are_not_judged():
    assert find_leakage(errors_of({4.8: 0.01}), (make_limit(4.8),), DatasetSpec(poses="paper-91")) == ""
