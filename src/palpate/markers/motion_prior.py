"""How the dots of one sensor move together: learnt from images whose correspondence is known, a prior for all others.

Displacements are taken as mean + Σ c_i d_i with c of unit variance (probabilistic principal components, Tipping and
Bishop 1999, doi 10.1111/1467-9868.00196). The likeliest coordinates are found from the dots that are assigned, those
that fit badly weighing less; dots that are lost or fused have the place that the others give them. Unlike a smooth
field this knows kinks, where the sensor has them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray

_MOST, _ROUNDS = 48, 3
_NOISE = 0.02
"""Least noise of a dot's place, over the spacing."""


@dataclass(frozen=True, eq=False)
class MotionPrior:
    """Motions of a sensor.

    Attributes
    ----------
    mean
        (2m,) mean displacement, px.
    directions
        (2m, k) principal directions times their deviations, px.
    noise_px
        What is left of a coordinate, px.
    """

    mean: FloatArray
    directions: FloatArray
    noise_px: float

    def fit(self, moved_px: FloatArray, found: BoolArray) -> FloatArray:
        """The likeliest motion (m, 2), px, of displacements (m, 2) where they were found (m,)."""
        there = np.repeat(found, 2)
        basis, moved = self.directions[there], (moved_px.ravel() - self.mean)[there]
        weight = np.ones(len(moved))
        coordinates: FloatArray = np.zeros(basis.shape[1])
        hold = self.noise_px**2 * np.eye(basis.shape[1])
        for _ in range(_ROUNDS):
            part = basis * weight[:, None]
            coordinates = np.asarray(np.linalg.solve(part.T @ basis + hold, part.T @ moved), float)
            off = np.linalg.norm((moved - basis @ coordinates).reshape(-1, 2), axis=1)
            middle = float(np.median(off)) if len(off) else 0.0
            weight = np.repeat(1.0 / (1.0 + (off / max(2.0 * middle, self.noise_px)) ** 2), 2)
        return np.asarray((self.mean + self.directions @ coordinates).reshape(-1, 2))


def fit_motion_prior(fields: Sequence[FloatArray], spacing_px: float) -> MotionPrior:
    """Motions from displacements (m, 2), px, of images."""
    flat = np.array(fields, float).reshape(len(fields), -1)
    mean = flat.mean(axis=0)
    _, values, right = np.linalg.svd(flat - mean, full_matrices=False)
    kept = max(1, min(_MOST, len(fields) // 3))
    left = float((values[kept:] ** 2).sum()) / max(flat.size, 1)
    deviation = values[:kept] / np.sqrt(len(fields))
    return MotionPrior(mean, right[:kept].T * deviation, max(np.sqrt(left), _NOISE * spacing_px))
