"""A camera that drifts by so much a second is followed alike, however often it takes an image."""

import numpy as np
import pytest

from palpate.sensor.drift_filter import FRAME_S, DriftFilter, _ahead

NOISE_PX, PACE_PX_S, SECONDS = 0.01, 2e-3, 120.0


def follow(rate_hz: float, pace_px_s: float, seed: int = 0) -> tuple[float, float]:
    """What is followed at the end (px), and the pace (px/s), of a drift in one way."""
    rng, step = np.random.default_rng(seed), 1.0 / rate_hz
    follows = DriftFilter(np.array([[NOISE_PX**2]]), np.eye(1))
    drift = follows.initial()
    for time in np.arange(step, SECONDS + 0.5 * step, step):
        told = np.array([pace_px_s * time + NOISE_PX * rng.normal()])
        drift = follows.update(drift, told, step)
    return float(follows.motion(drift)[0]), abs(float(drift.mean[0, 1]))


@pytest.mark.parametrize("rate_hz", [5.0, 20.0, 60.0])
def test_a_drift_a_second_is_followed_alike_at_every_rate(rate_hz: float) -> None:
    drifted = PACE_PX_S * SECONDS
    found = [follow(rate_hz, PACE_PX_S, seed) for seed in range(8)]
    assert np.abs([moved - drifted for moved, _ in found]).max() < 0.03
    assert np.mean([moved for moved, _ in found]) == pytest.approx(drifted, abs=0.012)
    assert np.mean([pace for _, pace in found]) == pytest.approx(PACE_PX_S, rel=0.1)


def test_many_short_steps_are_one_long_one() -> None:
    """What is known of a time to come does not depend on how it is cut into steps."""
    follows = DriftFilter(np.array([[NOISE_PX**2]]), np.eye(1))
    drift = follows.update(follows.initial(), np.array([0.02]), 1.0)
    once, often = _ahead(drift, 2.0), drift
    for _ in range(8):
        often = _ahead(often, 0.25)
    assert often.mean == pytest.approx(once.mean, rel=1e-9)
    assert often.covariance == pytest.approx(once.covariance, rel=1e-9)


def test_without_a_clock_twenty_images_make_a_second() -> None:
    follows = DriftFilter(np.array([[NOISE_PX**2]]), np.eye(1))
    told = np.array([0.01])
    one, other = (follows.update(follows.initial(), told, *step) for step in ((), (FRAME_S,)))
    assert np.array_equal(one.mean, other.mean)
    assert pytest.approx(0.05) == FRAME_S
