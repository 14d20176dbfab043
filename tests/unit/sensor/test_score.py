"""Scores with intervals by press, and the depth's zero."""

import numpy as np
import pytest

from errors import refused
from palpate.core import generator
from palpate.learn import measure_errors
from palpate.sensor import find_depth_zero, score_readings


def readings(presses=12, images=8, shared=0.3, own=0.1):
    rng = generator(0, "score")
    press = np.repeat(np.arange(presses), images)
    truth = rng.uniform(-8, 8, (len(press), 3))
    return truth, truth + shared * rng.normal(size=(presses, 3))[press] + own * rng.normal(size=truth.shape), press


def test_the_figures_are_those_of_the_specification_grid():
    truth, estimates, press = readings()
    metrics = measure_errors(estimates, truth)
    assert [score.errors for score in score_readings(truth, estimates, press)] == [
        metrics.by_axis["rx"],
        metrics.by_axis["ry"],
        metrics.by_axis["depth"],
    ]


def test_intervals_know_that_images_of_a_press_are_alike():
    truth, estimates, press = readings()
    by_press = score_readings(truth, estimates, press)[0]
    by_image = score_readings(truth, estimates, np.arange(len(truth)))[0]
    widths = [score.rmse_interval[1] - score.rmse_interval[0] for score in (by_press, by_image)]
    assert by_press.rmse_interval[0] < by_press.errors.rmse < by_press.rmse_interval[1]
    assert widths[0] > 1.5 * widths[1]


def test_an_interval_covers_what_many_more_presses_give():
    true = np.sqrt(0.3**2 + 0.1**2)
    covered = 0
    for seed in range(40):
        rng = generator(seed, "cover")
        press = np.repeat(np.arange(30), 6)
        error = 0.3 * rng.normal(size=(30, 3))[press] + 0.1 * rng.normal(size=(180, 3))
        low, high = score_readings(np.zeros((180, 3)), error, press)[0].rmse_interval
        covered += low <= true <= high
    assert covered >= 33  # 95 % of 40 less what thirty presses leave to chance


def test_images_without_a_pose_are_left_out_and_counted_by_the_caller():
    truth, estimates, press = readings()
    estimates[:8] = np.nan
    score = score_readings(truth, estimates, press)[0]
    assert (score.images, score.presses) == (88, 11)
    with refused("evaluation-no-image"):
        score_readings(truth, np.full_like(estimates, np.nan), press)


def test_the_zero_is_found_whatever_the_robot_believes():
    depth = np.arange(0.0, 8.1, 0.8)
    estimated = depth + 0.02 * generator(0, "zero").normal(size=len(depth))
    estimated[:3] += 0.8  # below the trained range a model may say anything
    estimated[7] = np.nan
    zero = find_depth_zero(estimated, depth + 1.0)
    assert zero.offset == pytest.approx(1.0, abs=0.02)
    assert zero.spread < 0.03
    with refused("depth-zero-unknown"):
        find_depth_zero(estimated[:4], depth[:4])
