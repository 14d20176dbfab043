"""Errors of readings as in the paper's Table 3, with bootstrap intervals.

Images of one press are correlated, so whole presses are drawn with replacement (Efron and Tibshirani, *An
Introduction to the Bootstrap*, 1993, section 8.5). The maximum error has no interval, because a bootstrap is invalid
for it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from palpate.core import FloatArray, IntArray, generator
from palpate.design import TILT_SPACE
from palpate.learn import ErrorSummary

COMPONENTS = tuple((item.label, item.unit) for item in TILT_SPACE.components)
"""Names and units of rx, ry and depth in the paper."""
LEVEL = 0.95
"""Coverage of the intervals. By hand."""
DRAWS = 2000
"""Samples of an interval by simulation. By hand."""

PAPER_TABLE_3 = {
    "roll": ErrorSummary(rmse=0.58, mae=0.49, max=1.62, sd=0.54, bias=float("nan")),
    "pitch": ErrorSummary(rmse=0.57, mae=0.47, max=1.64, sd=0.49, bias=float("nan")),
    "depth": ErrorSummary(rmse=1.00, mae=1.00, max=1.40, sd=0.16, bias=float("nan")),
}
"""Errors of the sensor of Zaid et al. 2024, Table 3 (`palpate.core.PAPER`), degrees and mm."""


@dataclass(frozen=True)
class Score:
    """Errors of one component.

    Attributes
    ----------
    component, unit
        As in `COMPONENTS`.
    images, presses
        Number of images with a pose, and of their presses.
    errors
        RMSE, MAE, maximum absolute error, SD and bias.
    rmse_interval, mae_interval, sd_interval
        Ends of the intervals of `LEVEL`; equal to the figure for a single press.
    """

    component: str
    unit: str
    images: int
    presses: int
    errors: ErrorSummary
    rmse_interval: tuple[float, float]
    mae_interval: tuple[float, float]
    sd_interval: tuple[float, float]

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def score_readings(truth: FloatArray, estimates: FloatArray, press: IntArray, seed: int = 0) -> tuple[Score, ...]:
    """Compute the errors of roll, pitch and depth, (n, 3) in degrees and mm, with bootstrap intervals.

    Images whose estimate is not finite are left out; `press` (n,) is the number of the press.

    Raises
    ------
    PalpateError
        If no image has an estimate.

    Examples
    --------
    >>> truth = np.zeros((4, 3))
    >>> roll, pitch, depth = score_readings(truth, truth + [0.5, 0.0, 0.1], np.array([0, 0, 1, 1]))
    >>> roll.component, roll.errors.rmse, roll.presses
    ('roll', 0.5, 2)
    """
    read = np.isfinite(estimates).all(axis=1)
    errors, press = (estimates - truth)[read], press[read]
    return tuple(score_errors(*pair, errors[:, k], press, seed) for k, pair in enumerate(COMPONENTS))


def score_errors(component: str, unit: str, error: FloatArray, press: IntArray, seed: int = 0) -> Score:
    """Compute the figures of the errors (n,) of one component, of presses (n,)."""
    summary, drawn = ErrorSummary.of(error), _bootstrap(error, press, seed)
    ends = [tuple(float(v) for v in np.quantile(row, [0.5 - LEVEL / 2, 0.5 + LEVEL / 2])) for row in drawn]
    return Score(component, unit, len(error), len(np.unique(press)), summary, *ends)  # type: ignore[arg-type]


def _bootstrap(error: FloatArray, press: IntArray, seed: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return RMSE, MAE and SD of bootstrap repetitions, which draw whole presses with replacement."""
    _, which = np.unique(press, return_inverse=True)
    sums = np.stack(
        [np.bincount(which, weights) for weights in (np.ones(len(error)), error, np.abs(error), error**2)]
    )
    drawn = generator(seed, "bootstrap").integers(0, sums.shape[1], (DRAWS, sums.shape[1]))
    images, total, absolute, square = sums[:, drawn].sum(axis=-1)
    variance = np.maximum(square / images - (total / images) ** 2, 0.0)
    return np.sqrt(square / images), absolute / images, np.sqrt(variance)
