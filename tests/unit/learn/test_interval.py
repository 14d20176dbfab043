from dataclasses import replace

import numpy as np
import pytest
from synthetic import make_dataset

from palpate.datasets import draw_jitter
from palpate.learn import TrainingSpec, calibrate_interval, fit_ridge, measure_coverage, train
from palpate.learn.interval import press_quantile


@pytest.fixture(scope="module")
def dataset():
    return make_dataset(presses=800, depths=(2.4, 4.0, 5.6, 7.2))


@pytest.fixture(scope="module")
def estimator(dataset):
    return calibrate_interval(train(dataset, TrainingSpec(width=32, epochs=30)), dataset)


def jittered(images_px, seed=7):
    return draw_jitter(images_px, 2.0, np.random.default_rng(seed))


def test_the_quantile_of_single_images_is_the_conformal_one():
    scores = np.arange(1.0, 20.0)  # 19 presses: the 18th of 20 places
    assert press_quantile(scores, np.arange(19), 0.9) == 18.0
    assert press_quantile(scores[::-1], np.arange(19), 0.95) == 19.0


def test_too_few_presses_promise_nothing():
    assert press_quantile(np.ones(8), np.arange(8), 0.9) == np.inf
    assert press_quantile(np.ones(9), np.arange(9), 0.9) == 1.0


def test_a_press_counts_once_however_many_images_it_has():
    press = np.repeat(np.arange(20), [500] + [1] * 19)
    scores = np.where(press == 0, 100.0, press.astype(float))
    assert press_quantile(scores, press, 0.9) == 19.0


def test_the_quantile_keeps_its_promise_over_many_presses_and_correlated_images():
    rng = np.random.default_rng(0)
    shares = []
    for _ in range(400):
        size = rng.exponential(1.0, (41, 1))  # what the images of a press share
        scores = np.abs(size * rng.normal(size=(41, 6)))
        limit = press_quantile(scores[:40].ravel(), np.repeat(np.arange(40), 6), 0.9)
        shares.append((scores[40] <= limit).mean())
    assert np.mean(shares) == pytest.approx(0.9, abs=4 * np.std(shares) / 20)


def test_intervals_cover_nine_tenths_on_presses_that_did_not_calibrate(dataset, estimator):
    found = measure_coverage(estimator, dataset, seed=1)
    assert (found.level, found.presses) == (0.9, 80)
    assert 0.87 <= found.angle <= 0.93
    assert 0.87 <= found.depth <= 0.93


def test_coverage_is_measured_on_no_press_that_trained_or_calibrated(dataset, estimator):
    used = set(estimator.interval.presses)
    assert used.isdisjoint(dataset.press[~dataset.validation])
    spoiled = dataset.images_px.copy()
    spoiled[~dataset.validation | np.isin(dataset.press, list(used))] += 40.0
    again = measure_coverage(estimator, replace(dataset, images_px=spoiled), seed=1)
    assert again == measure_coverage(estimator, dataset, seed=1)


def test_a_poor_estimator_keeps_the_promise_by_wider_intervals(dataset, estimator):
    poor = replace(estimator, interval=None, biases=(*estimator.biases[:-1], estimator.biases[-1] + 0.5))
    found = measure_coverage(calibrate_interval(poor, dataset), dataset, seed=1)
    assert 0.87 <= found.angle <= 0.93
    assert found.half_width_deg > 1.2 * measure_coverage(estimator, dataset, seed=1).half_width_deg


def test_a_promise_that_is_not_kept_is_seen(dataset, estimator):
    narrow = replace(estimator, interval=replace(estimator.interval, factor=0.7 * estimator.interval.factor))
    assert measure_coverage(narrow, dataset, seed=1).angle < 0.8


def test_shallow_images_get_wider_intervals():
    linear = make_dataset(presses=300, bend=0.0, markers=40)
    images = linear.rest_px + (linear.images_px - linear.rest_px) * (linear.poses[:, 2] / 5.6)[:, None, None]
    grown = replace(linear, images_px=images)
    width = (
        calibrate_interval(train(grown, TrainingSpec(width=32, epochs=300)), grown).estimate(images).half_width[:, 0]
    )
    assert width[linear.poses[:, 2] == 2.4].mean() > 1.3 * width[linear.poses[:, 2] == 5.6].mean()


def test_few_presses_give_infinite_intervals_and_no_coverage():
    small = make_dataset(presses=40)
    calibrated = calibrate_interval(fit_ridge(small), small)
    assert len(calibrated.interval.presses) == 4
    assert np.isinf(calibrated.interval.factor).all()
    assert measure_coverage(calibrated, small) is None
    assert calibrated.interval.trained.false_alarm == pytest.approx(1 / 5)


def test_a_single_held_out_press_leaves_the_estimator_without_interval():
    small = make_dataset(presses=10)
    small = replace(small, validation=small.press == 0)
    assert calibrate_interval(fit_ridge(small), small).interval is None


def test_the_estimates_of_a_calibrated_estimator_are_the_same(dataset, estimator):
    bare = replace(estimator, interval=None)
    assert np.array_equal(estimator.predict(dataset.images_px[:20]), bare.predict(dataset.images_px[:20]))
    assert np.array_equal(estimator.estimate(dataset.images_px[:20]).pose, bare.predict(dataset.images_px[:20]))


def test_members_taken_out_of_an_ensemble_lose_its_interval(estimator):
    assert estimator.keep_members([0]).interval is None


def test_images_like_those_of_the_training_are_seldom_called_outside(dataset, estimator):
    found = measure_coverage(estimator, dataset, seed=1)
    assert found.false_alarm == 0.02
    assert found.flagged_ood <= 0.03


@pytest.mark.parametrize("what", ["swapped", "shifted", "one lost", "too far"])
def test_an_image_that_the_training_never_saw_is_called_outside(dataset, estimator, what):
    images = jittered(dataset.images_px[:200])
    if what == "swapped":
        images[:, [0, 5]] = images[:, [5, 0]]
    elif what == "shifted":
        images += 15.0
    elif what == "one lost":
        images[:, 3] += 12.0
    else:
        images = dataset.rest_px + 1.6 * (images - dataset.rest_px)
        images = images[np.hypot(*dataset.poses[:200, :2].T) > 10.0]
    assert estimator.estimate(images).out_of_distribution.mean() > 0.95


def test_a_pose_steeper_than_any_of_the_training_is_called_outside():
    wide = make_dataset(presses=600, bend=0.0, markers=60, jitter_px=1.0)
    tilt = np.hypot(wide.poses[:, 0], wide.poses[:, 1])
    narrow = {name: getattr(wide, name)[tilt < 6.0] for name in ("images_px", "poses", "press", "validation")}
    narrow |= {name: getattr(wide, name)[tilt < 6.0] for name in ("branch", "travel_mm")}
    inside = replace(wide, **narrow)
    estimator = calibrate_interval(fit_ridge(inside), inside)
    assert estimator.estimate(wide.images_px[tilt > 9.0]).out_of_distribution.all()
    assert estimator.estimate(wide.images_px[tilt < 5.0]).out_of_distribution.mean() < 0.02
