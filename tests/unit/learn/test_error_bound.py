from types import SimpleNamespace

import numpy as np
import pytest

from palpate.learn.error_bound import _reach, posterior_rmse

NOWHERE = np.array([[0.0, 0.0, np.inf]])


def rng():
    return np.random.default_rng(0)


def location_model(markers):
    """Half the coordinates move with rx, half with ry: two problems of a location under uniform noise."""
    return np.kron(np.eye(2), np.ones((markers, 1)))[None]


@pytest.mark.parametrize("markers", [3, 10, 40])
def test_posterior_mean_of_a_location_has_the_variance_of_the_midrange(markers):
    """Closed form: the middle of the range of n draws from U(−a, a) has the variance 2 a² / ((n + 1)(n + 2))."""
    found, error = posterior_rmse(location_model(markers), 2.0, NOWHERE, rng(), draws=20_000)
    exact = np.sqrt(2 * 2.0**2 / ((markers + 1) * (markers + 2)))
    assert error < 0.01 * exact
    assert found == pytest.approx(exact, abs=3.5 * error)


def test_bound_falls_with_the_number_of_markers_itself_not_its_root():
    few, many = (posterior_rmse(location_model(n), 2.0, NOWHERE, rng(), draws=2000)[0] for n in (50, 200))
    assert few / many == pytest.approx(4.0, rel=0.08)


def test_bound_is_proportional_to_the_jitter():
    one, two = (posterior_rmse(location_model(10), a, NOWHERE, rng(), draws=200)[0] for a in (1.0, 2.0))
    assert two == pytest.approx(2 * one, rel=1e-9)


def test_without_information_the_floor_is_the_spread_of_the_disc():
    poses = np.random.default_rng(1).normal(size=(400, 2))
    poses *= 12 * np.sqrt(np.random.default_rng(2).random((400, 1))) / np.linalg.norm(poses, axis=1, keepdims=True)
    discs = np.column_stack([poses, np.full(400, 12.0)])
    blind = np.tile(1e-9 * location_model(4), (400, 1, 1))
    found, error = posterior_rmse(blind, 2.0, discs, rng())
    assert found == pytest.approx(12 / 2, abs=0.3 + 3 * error)


def test_knowing_the_disc_only_helps():
    weak = 0.5 * location_model(4)
    free, _ = posterior_rmse(weak, 2.0, NOWHERE, rng(), draws=2000)
    tied, _ = posterior_rmse(weak, 2.0, np.array([[0.0, 0.0, 2.0]]), rng(), draws=2000)
    assert tied < 0.9 * free


def test_coordinates_mixed_by_another_unknown_make_it_harder():
    generator = np.random.default_rng(3)
    three = generator.normal(size=(1, 40, 3))
    three[..., 2] += three[..., 0]
    all_unknown, _ = posterior_rmse(three, 2.0, NOWHERE, rng(), draws=1000)
    depth_known, _ = posterior_rmse(three[..., :2].copy(), 2.0, NOWHERE, rng(), draws=1000)
    assert depth_known < 0.95 * all_unknown


def test_the_prior_reaches_as_far_as_an_unbroken_run_of_tilts():
    runs = ((SimpleNamespace(first_deg=0.0, last_deg=6.0), SimpleNamespace(first_deg=8.0, last_deg=8.0)), ())
    assert [_reach(SimpleNamespace(runs=runs), image) for image in (0, 1)] == [6.0, 0.0]
