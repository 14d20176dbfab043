"""Gauge studies: known variances, the classical tables of the balanced analysis of variance, and refusals."""

import numpy as np
import pytest

from errors import refused
from palpate.sensor import GaugeStudy
from palpate.sensor.gauge_study import TERMS, study_repeatability

SD = {"part": 4.0, "operator": 0.05, "day": 0.05, "part × operator": 0.03, "mounting": 0.06, "repeatability": 0.03}


def draw(seed, sizes=(6, 6, 5, 2, 2)):
    """Readings with the standard deviations `SD`, and the levels of their factors."""
    rng = np.random.default_rng(seed)
    levels = dict(zip(("part", "operator", "day", "mounting"), (x.ravel() for x in np.indices(sizes)), strict=False))
    value = SD["repeatability"] * rng.standard_normal(np.prod(sizes))
    for term, factors in TERMS.items():
        labels = np.unique(np.column_stack([levels[name] for name in factors]), axis=0, return_inverse=True)[
            1
        ].ravel()
        value += SD[term] * rng.standard_normal(labels.max() + 1)[labels]
    return value, levels


def test_known_variances_are_recovered_by_the_mean_of_studies():
    """Within four standard errors of the mean of 40 studies; 2000 studies are in docs/results/sensor."""
    found = np.array(
        [
            [each.variance for each in study_repeatability({"rx": value}, levels).components["rx"]][:-2]
            for value, levels in map(draw, range(40))
        ]
    )
    true = np.array(list(SD.values())) ** 2
    assert (np.abs(found.mean(axis=0) - true) < 4.0 * found.std(axis=0) / np.sqrt(len(found))).all()
    assert found.mean(axis=0)[[3, 4, 5]] == pytest.approx(true[[3, 4, 5]], rel=0.1)


def test_balanced_data_give_the_mean_squares_of_the_crossed_table():
    """Two crossed factors: the textbook estimators from means of parts, operators and cells."""
    rng, p, o, r = np.random.default_rng(3), 5, 4, 3
    y = rng.normal(0, 1.0, (p, 1, 1)) + rng.normal(0, 0.5, (1, o, 1)) + rng.normal(0, 0.3, (p, o, 1))
    y = y + rng.normal(0, 0.2, (p, o, r))
    cells, mean = y.mean(axis=2), y.mean()
    ms_part = o * r * np.sum((y.mean(axis=(1, 2)) - mean) ** 2) / (p - 1)
    ms_operator = p * r * np.sum((y.mean(axis=(0, 2)) - mean) ** 2) / (o - 1)
    between = cells - y.mean(axis=(1, 2))[:, None] - y.mean(axis=(0, 2)) + mean
    ms_both = r * np.sum(between**2) / ((p - 1) * (o - 1))
    ms_error = np.sum((y - cells[..., None]) ** 2) / (p * o * (r - 1))
    part, operator, _ = (x.ravel() for x in np.indices(y.shape))
    found = study_repeatability({"rx": y.ravel()}, {"part": part, "operator": operator})
    assert found.absent == ("day", "mounting")
    wanted = {
        "part": (ms_part - ms_both) / (o * r),
        "operator": (ms_operator - ms_both) / (p * r),
        "part × operator": (ms_both - ms_error) / r,
        "repeatability": ms_error,
    }
    assert {name: found.component("rx", name).variance for name in wanted} == pytest.approx(wanted)
    assert found.component("rx", "R&R").variance == pytest.approx(sum(wanted.values()) - wanted["part"])


def test_the_interval_of_repeatability_is_that_of_chi_square():
    from scipy.stats import chi2

    value, levels = draw(1)
    found = study_repeatability({"rx": value}, levels).component("rx", "repeatability")
    ends = found.dof * found.variance / chi2.ppf([0.975, 0.025], found.dof)
    assert (found.low, found.high) == pytest.approx(ends, rel=0.02)


def test_the_degrees_of_freedom_of_reproducibility_are_those_of_the_spread_of_its_estimates():
    """Mean squares of known factors: ν = 2 (mean / SD)² of 400 estimates, which the formula does not use."""
    rng, (p, o, d, m, _) = np.random.default_rng(2), (x.ravel() for x in np.indices((3, 5, 4, 2, 2)))
    found = []
    for _ in range(400):
        value = 0.1 * rng.standard_normal(5)[o] + 0.2 * rng.standard_normal((5, 4, 2))[o, d, m]
        study = study_repeatability(
            {"rx": value + 0.2 * rng.standard_normal(len(p))}, {"part": p, "operator": o, "day": d, "mounting": m}
        )
        found.append(study.component("rx", "reproducibility"))
    variance, dof = (np.array([getattr(each, name) for each in found]) for name in ("variance", "dof"))
    assert np.median(dof) == pytest.approx(2.0 * (variance.mean() / variance.std()) ** 2, rel=0.25)
    assert dof.min() >= 1.0


def test_mountings_need_repetition_within_an_operator_and_a_day():
    """Without it, their term is operator × day: no column, or one label for each operator and day."""
    rng, (p, o, d, _) = np.random.default_rng(0), (x.ravel() for x in np.indices((4, 3, 3, 2)))
    value, levels = {"rx": rng.standard_normal(len(p))}, {"part": p, "operator": o, "day": d}
    for found in (study_repeatability(value, levels | extra) for extra in ({}, {"mounting": 3 * o + d})):
        assert found.absent == ("mounting",)
        assert found.component("rx", "operator × day").dof == 4
    assert study_repeatability(value, levels | {"mounting": p % 2}).absent == ()


def write(path, text):
    path.write_text(text)
    return path


def test_a_table_is_read_with_its_total_angle(tmp_path):
    rows = "\n".join(f"P{k % 3},A,{3 + k % 3 + 0.01 * (k // 3)},4" for k in range(12))
    found = GaugeStudy.read(write(tmp_path / "g.csv", f"part,operator,rx_deg,ry_deg\n{rows}\n"))
    assert found.readings == 12
    assert found.component("ry", "repeatability").variance == pytest.approx(0.0, abs=1e-12)
    assert 0 < found.component("total angle", "repeatability").variance < found.component("rx", "part").variance
    assert found.absent == ("operator", "day", "part × operator", "mounting")
    assert found.component("rx", "reproducibility").variance == 0
    rows = rows.replace("A,", " A ,", 3)
    spaced = GaugeStudy.read(write(tmp_path / "g.csv", f"part,operator,rx_deg,ry_deg\n{rows}\n"))
    assert spaced.components == found.components


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("part,rx_deg\nA,1\nA,2\n", ("column-missing", "ry_deg")),
        ("part,rx_deg,ry_deg\nA,1,2\nA,,2\n", ("angle-missing",)),
        ("part,rx_deg,ry_deg\nA,1,2\nB,2,2\n", ("gauge-no-repetition",)),
        ("part,rx_deg,ry_deg\nA,1,2\nA,91,2\n", ("angle-missing", "90")),
        ("part,operator,rx_deg,ry_deg\nA,B,1,2\nA,,1,2\n", ("gauge-cell-empty", "operator")),
        ("part,day,rx_deg,ry_deg\nA,1,1,2\nA,,1,2\n", ("gauge-cell-empty", "day")),
    ],
)
def test_a_table_without_a_study_is_refused(tmp_path, text, says):
    with refused(*says):
        GaugeStudy.read(write(tmp_path / "g.csv", text))
