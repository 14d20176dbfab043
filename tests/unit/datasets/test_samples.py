"""Samples of a signal at the times of images, and the clock offset between both."""

import numpy as np
import pytest

from palpate.datasets.samples import Samples, find_offset


@pytest.mark.parametrize("offset", [0.31, -0.422, 0.263])
@pytest.mark.parametrize("period", [0.1, 0.2])
def test_an_offset_is_found_to_half_a_millisecond_at_any_rate_of_images(offset: float, period: float) -> None:
    """Images every 0.2 s are searched in steps of 25 ms; twice as long steps would be off by more than 1 ms."""
    rates, phases = 0.3 * np.array([1.0, 1.37, 1.71, 2.2]), np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 4)

    def motion(time: np.ndarray) -> np.ndarray:
        return np.sin(2.0 * np.pi * np.multiply.outer(time, rates) + phases).sum(axis=-1)

    known, time = np.arange(-2.0, 14.0, 0.002), period * np.arange(40)
    small = np.broadcast_to(motion(time - offset)[:, None, None], (40, 4, 4))
    found, notes = find_offset(time, small, known, [np.diff(motion(known))], "poses")
    assert found == pytest.approx(offset, abs=5e-4)
    assert len(notes) == 1


def test_values_are_linear_between_samples_and_absent_in_gaps_and_outside() -> None:
    """The median period is 1 s: samples 3 s apart surround a time, samples 3.1 s apart do not."""
    time = np.array([3.0, 0.0, 1.0, 2.0, 6.0, 7.0, 8.0, 9.0, 12.1, 1.0])
    samples = Samples.of(time, 2.0 * time[:, None])
    assert np.array_equal(samples.time, np.unique(time))
    found = samples.at(np.array([-0.1, 0.0, 2.25, 4.5, 9.0, 10.0, 12.1, 12.2]))[:, 0]
    assert found == pytest.approx([np.nan, 0.0, 4.5, 9.0, 18.0, np.nan, np.nan, np.nan], nan_ok=True)
