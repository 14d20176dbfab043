"""The report of a relaxation: its ramp, its terms and what is left, by the series itself."""

import numpy as np
import pytest

from palpate.cli.fit_relaxation import describe_relaxation
from palpate.material import RelaxationTest, fit_relaxation


def strained(begin: float, end: float, last: float = 60.0) -> RelaxationTest:
    """A strain that begins at a time, is whole at another and is held, of a material that loses a quarter."""
    time = np.concatenate([np.linspace(0.0, end, 101), end + np.geomspace(0.05, last, 200)])
    strain = np.clip((time - begin) / (end - begin), 0.0, 1.0)
    stress = 40.0 * strain * (0.75 + 0.25 * np.exp(-np.maximum(time - end, 0.0) / 5.0))
    return RelaxationTest("pulled", time, np.maximum(stress, 1e-9), strain, ("as it came",))


def test_the_ramp_of_a_relaxation_lasts_from_its_begin_to_its_end() -> None:
    test = strained(1.0, 3.0)
    found = fit_relaxation([test])
    facts = describe_relaxation([test], found)
    (sample,) = facts["samples"]
    assert (sample["name"], sample["rows"], sample["notes"]) == ("pulled", 301, ["as it came"])
    assert sample["came_s"] == pytest.approx(2.0, abs=0.15)
    series = found.relaxation
    assert [term["share"] for term in facts["terms"]] == list(series.shares)
    assert [term["time_s"] for term in facts["terms"]] == list(series.times)
    for term, low, high in zip(facts["terms"], *np.array(found.intervals)[: len(series.shares)].T, strict=True):
        assert term["share_interval"] == pytest.approx([low, high], nan_ok=True)
    times = [item["time_s"] for item in facts["left"]]
    assert (times[0], times[-1]) == (found.first, found.last)
    assert [np.log10(time) % 1 for time in times[1:-1]] == [0.0] * (len(times) - 2)
    assert [item["left"] for item in facts["left"]] == pytest.approx(series.relaxation_function(np.array(times)))
    assert facts["left"][0]["left"] > facts["left"][-1]["left"]
    assert (facts["rows"], facts["rms"], facts["greatest"]) == (found.count, found.rms, found.max_error)
