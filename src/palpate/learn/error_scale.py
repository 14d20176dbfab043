"""Expected error of an estimate, image by image: the scale of its interval.

The logarithm of the variance of an error is linear in features of the image: the estimated pose and its squares, the
number of markers that were not found, the distance to the nearest training image, and the disagreement of the
estimators. The coefficients have the maximum likelihood for normal errors, with a ridge penalty (Davidian & Carroll
1987, "Variance function estimation"). The interval is this scale times a conformal quantile (Lei et al. 2018,
"Distribution-free predictive inference for regression", section 5.2), which keeps the level on average, up to the
difference between the scales of the folds and that of all images.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.core import FloatArray, IntArray, generator
from palpate.learn.interval import press_quantile

LEAST_IMAGES, LEAST_PRESSES = 100, 50
"""Numbers of validation images and presses below which all images get the same interval. By hand."""
_PENALTY, _STEPS, _FOLDS = 4.0, 30, 5
"""Ridge penalty of a coefficient, Fisher steps, and folds of the normalised errors. By hand."""
_FAR = 3.0
"""Standard deviations to which a feature is limited. By hand."""


@dataclass(frozen=True, eq=False)
class ErrorScale:
    """Expected error of an image from its features.

    Attributes
    ----------
    mean, sd
        (f,) of the features.
    weights
        (1 + f, k) of the logarithm of the variance.
    """

    mean: FloatArray
    sd: FloatArray
    weights: FloatArray

    def expected(self, features: FloatArray) -> FloatArray:
        """Expected error (n, k) of images with features (n, f), in the units of the components."""
        return np.asarray(np.exp(0.5 * (_columns(features, self.mean, self.sd) @ self.weights)))

    def to_lists(self) -> list[Any]:
        """Plain data, see `from_lists`."""
        return [self.mean.tolist(), self.sd.tolist(), self.weights.tolist()]

    @classmethod
    def from_lists(cls, data: list[Any]) -> ErrorScale:
        """Scale from plain data."""
        return cls(*(np.array(each, float) for each in data))


def image_features(
    poses: FloatArray,
    low: FloatArray,
    high: FloatArray,
    missing: FloatArray,
    nearest_px: FloatArray,
    apart: FloatArray,
) -> FloatArray:
    """Features (n, f) of images on which the expected error depends.

    Parameters
    ----------
    poses, low, high
        (n, k) estimates, and (k,) range of the training poses.
    missing, nearest_px
        (n,) number of markers that were not found, and RMS distance to the nearest training image; 0 without markers.
    apart
        (n, k) standard deviation of the estimates of the parts.
    """
    at = (poses - (low + high) / 2) / np.maximum((high - low) / 2, 1e-12)
    spread = (apart / np.maximum(high - low, 1e-12)).mean(axis=1)
    more = [np.log1p(missing), np.log(nearest_px + 0.1), np.log(spread + 1e-4)]
    return np.hstack([at, at**2, np.stack(more, axis=1)])


def fit_scale(
    features: FloatArray, errors: FloatArray, press: IntArray, level: float
) -> tuple[FloatArray, ErrorScale | None]:
    """Quantile (k,) by which the scale is multiplied for intervals of a level, and the scale.

    Without a scale, for few images, the quantile is the half-width itself.

    Parameters
    ----------
    features, errors, press
        (n, f) features, (n, k) errors and (n,) presses of images that trained nothing.
    level
        Share of the errors of a new press inside.
    """
    presses = np.unique(press)
    if len(errors) < LEAST_IMAGES or len(presses) < LEAST_PRESSES:
        return press_quantile(np.abs(errors), press, level), None
    fold = (generator(0, "scale").permutation(len(presses)) % _FOLDS)[np.searchsorted(presses, press)]
    normalised = np.empty_like(errors)
    for number in range(_FOLDS):
        own = fold == number
        normalised[own] = np.abs(errors[own]) / _fit(features[~own], errors[~own]).expected(features[own])
    return press_quantile(normalised, press, level), _fit(features, errors)


def _fit(features: FloatArray, errors: FloatArray) -> ErrorScale:
    mean, sd = features.mean(axis=0), features.std(axis=0)
    sd = np.where(sd > 1e-9, sd, 1.0)
    columns = _columns(features, mean, sd)
    penalty = np.diag([0.0, *[_PENALTY] * features.shape[1]])
    information = 0.5 * columns.T @ columns + penalty
    squares = np.maximum(errors**2, 1e-12 * np.maximum(np.mean(errors**2, axis=0), 1e-300))
    weights = np.zeros((columns.shape[1], errors.shape[1]))
    weights[0] = np.log(squares.mean(axis=0))
    for _ in range(_STEPS):
        ratio = np.minimum(squares / np.exp(columns @ weights), 1e3)
        gradient = 0.5 * columns.T @ (ratio - 1.0) - penalty @ weights
        weights = weights + np.clip(np.linalg.solve(information, gradient), -1.0, 1.0)
    return ErrorScale(mean, sd, weights)


def _columns(features: FloatArray, mean: FloatArray, sd: FloatArray) -> FloatArray:
    standardised = np.clip((features - mean) / sd, -_FAR, _FAR)
    return np.hstack([np.ones((len(features), 1)), standardised])
