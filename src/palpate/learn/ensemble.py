"""Selection and weighting of estimators, by minimum error on validation presses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import nnls

from palpate.core import BoolArray, FloatArray
from palpate.learn.error_scale import ErrorScale

MIXTURE, PICTURES = "mixture", "mixture of pictures"
"""Ensembles of all estimators, and of image networks."""
_LEAST = 0.03
"""Weight below which an estimator is left out of an ensemble. By hand."""
_LEAST_MIXED = 30
"""Minimum number of validation images for an ensemble: fewer do not determine its weights. By hand."""
_GAIN = 0.97
"""An ensemble is selected if its error is below this share of the best single estimator's. By hand."""


@dataclass(eq=False)
class Ensemble:
    """Weighted estimators of a pose.

    Attributes
    ----------
    parts, weights
        Names, and (parts, k) weights of each component.
    half_width, scale
        (k,) half-widths of its intervals, over the expected errors of `scale` if there is one.
    name, error
        The estimator, or ``mixture``; its RMSE on the validation images, over the standard deviations of the targets.
    """

    parts: tuple[str, ...]
    weights: FloatArray
    half_width: FloatArray = field(default_factory=lambda: np.zeros(0))
    name: str = ""
    error: float = float("nan")
    scale: ErrorScale | None = None

    def half_widths(self, features: FloatArray) -> FloatArray:
        """Half-widths (n, k) of the intervals of images with features (n, f), see `image_features`."""
        if self.scale is None:
            return np.tile(self.half_width, (len(features), 1))
        return self.half_width * self.scale.expected(features)

    def combine(self, estimates: Mapping[str, FloatArray]) -> FloatArray:
        """Combine the estimates of the parts to (n, k)."""
        return np.asarray(
            sum(weight * estimates[name] for name, weight in zip(self.parts, self.weights, strict=True))
        )

    def spread(self, estimates: Mapping[str, FloatArray]) -> FloatArray:
        """Standard deviation (n, k) of the estimates of the parts about their combination."""
        mean = self.combine(estimates)
        off = [weight * (estimates[name] - mean) ** 2 for name, weight in zip(self.parts, self.weights, strict=True)]
        return np.asarray(np.sqrt(sum(off)))


def select_ensemble(
    estimates: Mapping[str, FloatArray],
    targets: FloatArray,
    choose: BoolArray,
    scale: FloatArray,
    from_markers: set[str],
) -> tuple[list[Ensemble], Ensemble | None, Ensemble | None]:
    """Rank estimators by validation error; return all, the best, and the best on images (or `None`).

    Parameters
    ----------
    estimates
        Name → (n, k) estimates, NaN if an estimator cannot read an image.
    targets, choose, scale
        (n, k) poses, (n,) validation images, (k,) divisors of the errors.
    from_markers
        Names of the estimators on marker positions.
    """
    scale = np.where(scale > 0, scale, 1.0)
    whole = choose & np.all([np.isfinite(one).all(axis=1) for one in estimates.values()], axis=0)
    whole = whole if whole.any() else choose
    ones = np.ones((1, targets.shape[1]))

    def error(found: FloatArray) -> float:
        off = ((found - targets) / scale)[whole]
        return float(np.sqrt(np.nanmean(off**2)))

    ranked = [Ensemble((name,), ones, name=name, error=error(found)) for name, found in estimates.items()]
    ranked.sort(key=lambda option: option.error)

    def best_of(names: list[str], rows: BoolArray, title: str) -> Ensemble | None:
        """Best single estimator, or the ensemble if it is clearly better; both are ranked."""
        alone = next((option for option in ranked if option.name in names), None)
        mixed = _mix(title, {name: estimates[name] for name in names}, targets, rows)
        if alone is None or mixed is None:
            return alone
        mixed.error = error(mixed.combine(estimates))
        ranked.append(mixed)
        return mixed if mixed.error < _GAIN * alone.error else alone

    pictures = [name for name in estimates if name not in from_markers]
    best = best_of(list(estimates), whole, MIXTURE)
    without = best_of(pictures, choose, PICTURES) if len(pictures) < len(estimates) else best
    return sorted(ranked, key=lambda option: option.error), best, without


def _mix(title: str, estimates: Mapping[str, FloatArray], targets: FloatArray, rows: BoolArray) -> Ensemble | None:
    """Non-negative least-squares weights of each component, summing to one; `None` for one part."""
    names = list(estimates)
    if len(names) < 2 or rows.sum() < _LEAST_MIXED:
        return None
    weights = np.zeros((len(names), targets.shape[1]))
    for column in range(targets.shape[1]):
        off = np.stack([estimates[name][rows, column] - targets[rows, column] for name in names], axis=1)
        size = float(np.sqrt((off**2).mean(axis=0).min()))
        hold = 1e3 * size * np.sqrt(rows.sum())
        found, _ = nnls(np.vstack([off, np.full((1, len(names)), hold)]), np.append(np.zeros(len(off)), hold))
        found[found < _LEAST] = 0.0
        weights[:, column] = found / max(found.sum(), 1e-12)
    used = np.asarray(weights.any(axis=1))
    if used.sum() < 2:
        return None
    return Ensemble(tuple(name for name, kept in zip(names, used, strict=True) if kept), weights[used], name=title)
