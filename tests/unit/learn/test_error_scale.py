"""Expected errors image by image: coverage in every bin, and a control with one width."""

import numpy as np
import pytest

from palpate.learn.error_scale import ErrorScale, fit_scale, image_features
from palpate.learn.interval import press_quantile

LEVEL = 0.9


def drawn(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Features (n, f) and errors (n, 2), larger at small depth and with missing markers."""
    rng = np.random.default_rng(seed)
    poses = rng.uniform([-20, -20, 0.5], [20, 20, 6.0], (count, 3))
    missing = rng.poisson(rng.choice([1.0, 15.0], count, p=[0.8, 0.2]))
    nearest, apart = rng.lognormal(0, 0.3, count), rng.lognormal(-2, 0.3, (count, 3))
    sd = 0.1 * (1 + 8 * np.exp(-poses[:, 2])) * (1 + missing / 6)
    features = image_features(poses, np.array([-20, -20, 0.5]), np.array([20, 20, 6.0]), missing, nearest, apart)
    return features, sd[:, None] * rng.standard_t(5, (count, 2)) * [1.0, 3.0]


def test_every_bin_of_depth_and_missing_markers_is_covered_and_with_one_width_none_is() -> None:
    features, errors = drawn(600, 0)
    factor, scale = fit_scale(features, errors, np.arange(600), LEVEL)
    assert scale is not None
    width = press_quantile(np.abs(errors), np.arange(600), LEVEL)
    features, errors = drawn(20_000, 1)
    inside, plain = np.abs(errors) <= factor * scale.expected(features), np.abs(errors) <= width
    depth, lost = features[:, 2], np.expm1(features[:, 6])
    bins = [
        *(np.digitize(depth, [-0.8, 0.0, 0.8]) == k for k in range(4)),
        lost < 3,
        (lost > 3) & (lost < 12),
        lost > 12,
    ]
    own, control = (np.array([each[rows].mean() for rows in bins]) for each in (inside, plain))
    assert own.min() > 0.82
    assert own.max() < 0.96
    assert control.min() < 0.75
    assert inside.mean() == pytest.approx(LEVEL, abs=0.025)


def test_few_images_get_one_width() -> None:
    features, errors = drawn(60, 2)
    width, scale = fit_scale(features, errors, np.arange(60), LEVEL)
    assert scale is None
    assert width == pytest.approx(press_quantile(np.abs(errors), np.arange(60), LEVEL))


def test_a_scale_survives_its_plain_data() -> None:
    features, errors = drawn(300, 3)
    _, scale = fit_scale(features, errors, np.arange(300), LEVEL)
    assert scale is not None
    assert ErrorScale.from_lists(scale.to_lists()).expected(features) == pytest.approx(scale.expected(features))


def test_equal_errors_give_equal_scales() -> None:
    features, _ = drawn(800, 4)
    errors = np.random.default_rng(5).normal(0, 0.2, (800, 2))
    _, scale = fit_scale(features, errors, np.arange(800), LEVEL)
    assert scale is not None
    assert scale.expected(features).std() < 0.15 * scale.expected(features).mean()


def test_features_are_relative_to_the_range_of_the_training() -> None:
    low, high = np.array([-20.0, 1.0]), np.array([20.0, 5.0])
    (found,) = image_features(
        np.array([[10.0, 5.0]]), low, high, np.array([3.0]), np.array([0.9]), np.array([[4.0, 0.2]])
    )
    spread = (4.0 / 40.0 + 0.2 / 4.0) / 2
    wanted = [0.5, 1.0, 0.25, 1.0, np.log(4.0), np.log(1.0), np.log(spread + 1e-4)]
    assert found == pytest.approx(wanted)
