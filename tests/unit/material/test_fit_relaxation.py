"""Fits to relaxations that no Prony series made: continuous spectra, ramps, noise; and one that was measured."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.special import exp1

from errors import refused
from palpate.material import Moduli, RelaxationTest, draw_relaxation, fit_relaxation, read_relaxation

DATA = Path(__file__).parents[1] / "material" / "data" / "springer_2022" / "relax_master.csv"
NOISE = 0.005


def stretched(t):
    """Kohlrausch's stretched exponential, a quarter lost."""
    return 0.75 + 0.25 * np.exp(-((np.asarray(t) / 5.0) ** 0.35))


def power(t):
    """A power law of three decades and more, without an end."""
    return (1 + np.asarray(t) / 0.02) ** -0.06


def spectrum(t):
    """A box spectrum from 0.03 to 300 s by exponential integrals: as much relaxes in every decade between."""
    t = np.maximum(t, 1e-12)  # the integrals of t = 0 are infinite, their difference is not
    return 0.8 + 0.2 / np.log(1e4) * (exp1(t / 300.0) - exp1(t / 0.03))


def ramped(g, time, rate_time):
    """Answer to a strain that comes evenly in `rate_time`: ``∫ g(t - s) ds / t_r`` by Gauss quadrature in pieces."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    found = np.zeros(len(time))
    for k, t in enumerate(time):
        far, near = t, max(t - rate_time, 0.0)
        edges = np.concatenate([[near], near + (far - near) * np.geomspace(1e-6, 1, 15)])
        for a, b in pairwise(edges):
            at = 0.5 * (a + b) + 0.5 * (b - a) * nodes
            found[k] += 0.5 * (b - a) * weights @ g(at) / rate_time
    return found


def greatest_miss(fit, g, first, last):
    """Greatest difference of the series from the true curve over the times measured, the scale of both free."""
    t = np.geomspace(first, last, 200)
    ratio = fit.relaxation.relaxation_function(t) / g(t)
    return (ratio.max() - ratio.min()) / (ratio.max() + ratio.min())


@pytest.mark.parametrize("g", [stretched, power, spectrum])
@pytest.mark.parametrize("even", [False, True])
def test_a_continuous_spectrum_is_met_within_a_per_cent(g, even):
    """A step, rows even in log time or in time, noise of half a per cent; one decay alone must fail."""
    rng = np.random.default_rng(3)
    time = np.linspace(0.2, 300, 1500) if even else np.geomspace(0.05, 300, 300)
    test = RelaxationTest("drawn", time, 40 * g(time) * (1 + NOISE * rng.normal(size=len(time))))
    test.check()
    fit, one = fit_relaxation([test]), fit_relaxation([test], terms=1)
    assert greatest_miss(fit, g, time[0], time[-1]) < 0.01
    assert greatest_miss(one, g, time[0], time[-1]) > 0.015
    assert 2 <= len(fit.relaxation.times) <= np.ceil(np.log10(time[-1] / time[0]))


@pytest.mark.parametrize("g", [stretched, spectrum])
@pytest.mark.parametrize("measured", [True, False])
def test_a_ramp_is_fitted_as_a_ramp(g, measured):
    """A strain that takes 2 s, with its column or without; taken for a step, the same rows must miss."""
    rng = np.random.default_rng(8)
    time = np.concatenate([np.linspace(0, 2, 41), np.geomspace(2.05, 300, 260)])
    stress = ramped(g, np.maximum(time, 1e-9), 2.0) * (1 + NOISE * rng.normal(size=len(time)))
    strain = 0.1 * np.minimum(time / 2, 1) * (1 + 0.001 * rng.normal(size=len(time))) if measured else None
    test = RelaxationTest("ramp", time, stress, strain)
    test.check()
    assert test.ramp_times == pytest.approx((0.0, 2.0), abs=0.2)
    assert greatest_miss(fit_relaxation([test]), g, 2.0, 300.0) < 0.01
    held = time > 2
    step = fit_relaxation([RelaxationTest("step", time[held] - 2, stress[held])])
    assert greatest_miss(step, g, 0.05, 300.0) > 0.01


@pytest.mark.parametrize("measured", [True, False])
def test_a_bench_that_waits_before_it_strains_is_fitted_alike(measured):
    """Ten seconds at nothing first, by a clock of its own: the strain begins where it begins, not with the file."""
    time = np.concatenate([np.linspace(0, 2, 41), np.geomspace(2.05, 300, 260)])
    stress, strain = ramped(spectrum, np.maximum(time, 1e-9), 2.0), 0.1 * np.minimum(time / 2, 1)
    late = np.concatenate([np.linspace(-60, -50, 50, endpoint=False), time - 50])
    waits = [np.concatenate([np.zeros(50), part]) for part in (stress, strain)]
    prompt = RelaxationTest("prompt", time, stress, strain if measured else None)
    waited = RelaxationTest("waited", late, waits[0], waits[1] if measured else None)
    waited.check()
    assert waited.ramp_times == pytest.approx((-50.0, -48.0))
    ours, theirs = fit_relaxation([waited]), fit_relaxation([prompt])
    assert (ours.first, ours.last) == pytest.approx((theirs.first, theirs.last))
    assert ours.relaxation.relaxation_function(time) == pytest.approx(
        theirs.relaxation.relaxation_function(time), rel=1e-6
    )
    drawn, plain = (draw_relaxation([each], ours).axes[0].lines[0] for each in (waited, prompt))
    assert drawn.get_xydata() == pytest.approx(plain.get_xydata(), rel=1e-6)


def test_measured_stresses_are_drawn_on_the_curve_of_their_series():
    """Behind a ramp, after a step, and held from the first row: within the fit of the curve that is drawn."""
    time = np.concatenate([np.linspace(0, 2, 41), np.geomspace(2.05, 300, 260)])
    ramp, step = ramped(spectrum, np.maximum(time, 1e-9), 2.0), spectrum(time[1:])
    tests = [
        RelaxationTest("ramp", time, ramp, 0.1 * np.minimum(time / 2, 1)),
        RelaxationTest("step", time[1:], step),
        RelaxationTest("held", time[1:], spectrum(time[1:] - time[1]), np.full(len(time) - 1, 0.1)),
    ]
    for test in tests:
        fit = fit_relaxation([test])
        at, seen = draw_relaxation([test], fit).axes[0].lines[0].get_xydata().T
        late = at > 20 * 2.0  # a ramp is a step by then
        assert seen[late] == pytest.approx(fit.relaxation.relaxation_function(at[late]), rel=0.01)


def test_the_intervals_cover_a_series_that_was_drawn():
    """Of two terms a decade apart, drawn 40 times: the 90 % intervals hold each constant some nine times in ten."""
    time, hits, drawn = np.geomspace(0.02, 200, 120), np.zeros(4), np.array([0.08, 0.12, 0.3, 15])
    for seed in range(40):
        rng = np.random.default_rng(seed)
        curve = 0.8 + 0.08 * np.exp(-time / 0.3) + 0.12 * np.exp(-time / 15)
        test = RelaxationTest("two", time, curve * (1 + NOISE * rng.normal(size=len(time))))
        fit = fit_relaxation([test], confidence=0.9, terms=2)
        low, high = fit.intervals.T
        hits += (low <= drawn) & (high >= drawn)
    assert (hits >= 31).all()
    assert hits.sum() <= 158


def test_the_number_of_terms_of_a_series_is_found():
    rng, time = np.random.default_rng(0), np.geomspace(0.01, 1000, 200)
    curve = 0.7 + 0.1 * np.exp(-time / 0.1) + 0.2 * np.exp(-time / 50)
    fit = fit_relaxation([RelaxationTest("two", time, curve * (1 + 0.002 * rng.normal(size=len(time))))])
    assert len(fit.relaxation.times) == 2
    assert fit.relaxation.times == pytest.approx((0.1, 50), rel=0.1)
    assert fit.relaxation.shares == pytest.approx((0.1, 0.2), rel=0.05)


def test_tests_of_other_strains_and_times_are_fitted_together():
    """Two specimens, one soon and one late: neither alone knows both decades."""
    rng = np.random.default_rng(1)
    early, late = np.geomspace(0.01, 2, 80), np.geomspace(1, 500, 80)
    tests = [
        RelaxationTest("a", t, size * spectrum(t) * (1 + NOISE * rng.normal(size=len(t))))
        for t, size in ((early, 3.0), (late, 70.0))
    ]
    fit = fit_relaxation(tests, moduli=Moduli.INSTANTANEOUS)
    assert (fit.first, fit.last) == pytest.approx((0.01, 500))
    assert greatest_miss(fit, spectrum, 0.01, 500) < 0.01
    assert fit.relaxation.moduli is Moduli.INSTANTANEOUS


def test_a_measured_relaxation_is_met_within_a_per_cent():
    """A master curve of stress relaxation of a polymer film, five decades (data/README.md); one decay must fail."""
    test = read_relaxation(DATA)
    fit, one = fit_relaxation([test]), fit_relaxation([test], terms=1)
    assert fit.max_error < 0.0025
    assert one.max_error > 0.04
    off = fit.relaxation.relaxation_function(test.time) / test.stress
    assert off.max() / off.min() - 1 < 0.01  # every row as measured
    assert draw_relaxation([test], fit).axes[0].get_xscale() == "log"


def test_a_stress_that_levels_off_at_nothing_is_refused():
    time = np.geomspace(0.01, 100, 60)
    with refused("relaxation-not-levelled"):
        fit_relaxation([RelaxationTest("fluid", time, np.exp(-time / 20) + 1e-6)])


def test_fewer_rows_than_constants_are_refused():
    time = np.geomspace(0.01, 100, 8)
    with refused("fit-few-rows", "9", "8"):
        fit_relaxation([RelaxationTest("few", time, stretched(time))], terms=4)
    with refused("fit-no-samples"):
        fit_relaxation([])
    with refused("relaxation-term-count", "0"):
        fit_relaxation([RelaxationTest("few", time, stretched(time))], terms=0)
    with refused("held-stress-rises"):
        fit_relaxation([RelaxationTest("rising", time, stretched(time)[::-1])])
