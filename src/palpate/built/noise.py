"""How far dots are from where a model has them: noise of the detector, what the twin is off, false dots."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray

NOISE_PX = 0.02
"""Standard deviation of a dot's coordinate in an image of 346 x 260 px, as the detector finds it on the bench."""
MODEL_PX = 0.02
"""What the twin itself may be off, px."""
FREEDOM = 30.0
"""Degrees of freedom of Student's distribution, of dots that are not where they should be."""
_MEDIAN = 2.0 * np.log(2.0)
"""Median square of two normal numbers together."""


def weigh_dots(left: FloatArray, variance: float) -> FloatArray:
    """Weights (2 n,) of coordinates over their variance, by Student's distribution: less for dots that fit badly.

    Where most dots fit badly, as at the beginning of an iteration, what is bad is measured by the median of them.
    """
    far = (left.reshape(-1, 2) ** 2).sum(axis=1) / variance
    scale = max(1.0, float(np.median(far)) / _MEDIAN) if len(far) else 1.0
    return np.repeat((FREEDOM + 2.0) / (FREEDOM + far / scale), 2) / variance
