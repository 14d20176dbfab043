"""A Prony series and what it makes of a history, held against quadrature of the convolution and closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad

from errors import refused
from palpate.material import Moduli, Relaxation, StressHistory, relax_history

SERIES = Relaxation((0.1, 0.05, 0.2), (0.02, 1.0, 30.0), Moduli.INSTANTANEOUS)


def test_what_is_left_is_all_at_first_and_the_end_at_last():
    assert SERIES.relaxation_function(0.0) == 1.0
    assert SERIES.relaxation_function([1e6])[0] == pytest.approx(0.65)
    assert SERIES.long_term_share == pytest.approx(0.65)


def test_moduli_say_at_which_time_the_constants_hold():
    slow = Relaxation(SERIES.shares, SERIES.times)
    assert slow.moduli is Moduli.LONG_TERM
    assert slow.modulus([1e6])[0] == pytest.approx(1.0)
    assert slow.modulus([0.0])[0] == pytest.approx(1 / 0.65)
    assert SERIES.modulus([0.0])[0] == 1.0


@pytest.mark.parametrize(
    ("shares", "times", "says"),
    [
        ((-0.1,), (1.0,), ("relaxation-share-negative", "1", "-0.1")),
        ((0.6, 0.4), (1.0, 2.0), ("relaxation-shares-sum", "1")),
        ((0.1,), (0.0,), ("relaxation-time-not-positive", "1", "0")),
        ((0.1,), (np.inf,), ("relaxation-time-not-positive", "1", "inf")),
        ((np.nan,), (1.0,), ("relaxation-share-negative", "1", "nan")),
        ((0.1, 0.1), (2.0, 1.0), ("relaxation-times-not-rising", "2, 1")),
        ((0.1, 0.1), (1.0, 1.0), ("relaxation-times-not-rising", "1, 1")),
        ((), (), ("relaxation-lengths-differ", "0")),
        ((0.1,), (1.0, 2.0), ("relaxation-lengths-differ", "1", "2")),
    ],
)
def test_a_series_that_is_none_is_refused_with_its_numbers(shares, times, says):
    with refused(*says) as caught:
        Relaxation(shares, times)
    assert caught.value.remedy


def test_a_history_of_straight_pieces_is_its_convolution():
    """Against adaptive quadrature of the integral, over steps from much shorter to much longer than the times."""
    time = np.array([0.0, 0.001, 0.5, 0.6, 7.0, 300.0, 301.0])
    elastic = np.array([0.0, 2.0, 2.5, -1.0, -1.0, 4.0, 4.0])
    found = relax_history(SERIES, time, elastic)
    for k in range(1, len(time)):
        exact = 0.0
        for a, b, low, high in zip(time[:k], time[1 : k + 1], elastic[:k], elastic[1 : k + 1], strict=True):
            points = [b - share * (b - a) for share in (1e-4, 1e-3, 1e-2, 0.1)]
            rate = (high - low) / (b - a)
            part = quad(
                lambda s, end=time[k]: float(SERIES.relaxation_function(end - s)), a, b, points=points, limit=200
            )
            exact += rate * part[0]
        assert found[k] == pytest.approx(exact, abs=1e-7)


def test_a_step_is_followed_at_any_rate_alike():
    coarse = relax_history(SERIES, np.array([0.0, 50.0]), np.array([3.0, 3.0]))
    fine = relax_history(SERIES, np.linspace(0, 50, 501), np.full(501, 3.0))
    assert coarse[-1] == pytest.approx(fine[-1], rel=1e-12)
    assert coarse[-1] == pytest.approx(3 * float(SERIES.relaxation_function(50.0)), rel=1e-12)


def test_vectors_relax_component_by_component():
    time, force = np.array([0.0, 0.3, 4.0]), np.array([[0.0, 1, 2], [3, 4, 5], [1, 1, 1]])
    found = relax_history(SERIES, time, force)
    for axis in range(3):
        assert found[:, axis] == pytest.approx(relax_history(SERIES, time, force[:, axis]), rel=1e-12)


def test_the_value_foreseen_is_the_one_that_comes():
    history = StressHistory(SERIES)
    history.update(0.0, 1.0)
    history.update(0.7, 2.0)
    a, b = history.affine(1.9)
    assert float(a) + b * 5.0 == pytest.approx(float(history.update(1.9, 5.0)), rel=1e-12)


def test_time_that_goes_back_is_refused():
    history = StressHistory(SERIES)
    history.update(2.0, 1.0)
    with refused("time-goes-back", "2", "1"):
        history.update(1.0, 1.0)
