"""Joint motion of markers, which predicts those without a blob or an assignment.

The motion of one sensor is mean + Σ c_i d_i with coordinates c of unit variance (probabilistic principal components,
Tipping and Bishop 1999, doi 10.1111/1467-9868.00196). The most probable coordinates are fitted to the found markers,
with smaller weights for bad fits, and predict the missing ones. Unlike a smooth field this model reproduces kinks of
the motion. Without images of the sensor, the motion is a quadratic function of the rest position, fitted to the
nearest found markers: valid for any design.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from palpate.core import BoolArray, FloatArray

_NEIGHBOURS, _QUADRATIC_FROM = 14, 9
"""Neighbours for a smooth motion, and minimum number for a quadratic one (else linear). By hand."""
_NOISE_PX = 0.3
"""Minimum misfit of a fitted model, px: noise of a blob and truncation of the modes. By hand."""
_MOST, _ROUNDS = 48, 3
"""Maximum number of modes, also limited to a third of the images; rounds of weighting. By hand."""


@dataclass(frozen=True, eq=False)
class MotionModel:
    """Joint motion of m markers from rest.

    Attributes
    ----------
    rest_px
        (m, 2) markers at rest.
    modes_px
        (k, m, 2) modes of motion, scaled to their standard deviations; `None` for any smooth motion.
    mean_px
        (m, 2) mean motion, or (2,) of all markers.
    noise_px
        Standard deviation of a coordinate about the modes.
    """

    rest_px: FloatArray
    modes_px: FloatArray | None = None
    mean_px: FloatArray = field(default_factory=lambda: np.zeros(2))
    noise_px: float = _NOISE_PX

    def fit(self, moved_px: FloatArray, found: BoolArray) -> FloatArray:
        """Return the most probable motion (m, 2), px, given displacements (m, 2) of the found markers (m,)."""
        assert self.modes_px is not None
        basis = self.modes_px[:, found].reshape(len(self.modes_px), -1)
        moved = (moved_px - self.mean_px)[found].ravel()
        weight = np.ones(len(moved))
        coordinates: FloatArray = np.zeros(len(basis))
        for _ in range(_ROUNDS):
            part = basis * weight
            coordinates = np.asarray(
                np.linalg.solve(part @ basis.T + self.noise_px**2 * np.eye(len(basis)), part @ moved), float
            )
            off = np.linalg.norm((moved - coordinates @ basis).reshape(-1, 2), axis=1)
            middle = float(np.median(off)) if len(off) else 0.0
            weight = np.repeat(1.0 / (1.0 + (off / max(2.0 * middle, self.noise_px)) ** 2), 2)
        return np.asarray(self.mean_px + np.tensordot(coordinates, self.modes_px, axes=1))

    def fill(self, seen_px: FloatArray, found: BoolArray) -> FloatArray:
        """Estimate positions (m, 2), px, of all markers from those of the found ones (m,).

        The residual of the modes is interpolated smoothly and added.
        """
        moved = seen_px - self.rest_px
        if self.modes_px is None:
            return self.rest_px + self._smooth(moved[found], found)
        motion = self.fit(moved, found)
        if found.sum() >= 4 and not found.all():
            motion = motion + self._smooth((moved - motion)[found], found)
        return np.asarray(self.rest_px + motion)

    def _smooth(self, moved: FloatArray, found: BoolArray) -> FloatArray:
        result = np.empty_like(self.rest_px)
        result[found] = moved
        if not found.all():
            result[~found] = interpolate_motion(self.rest_px[found], moved, self.rest_px[~found])
        return result


def interpolate_motion(points: FloatArray, moved: FloatArray, places: FloatArray) -> FloatArray:
    """Interpolate the motion (n, 2) px of points (n, 2) to places (k, 2), smoothly.

    Moving least squares of a quadratic polynomial over the nearest points, except a point at the place itself; the
    mean for fewer than four points.
    """
    if len(points) < 4:
        return np.broadcast_to(moved.mean(axis=0) if len(moved) else 0.0, places.shape).copy()
    square = ((places[:, None] - points[None]) ** 2).sum(axis=-1)
    square[square == 0.0] = np.inf
    count = min(_NEIGHBOURS, int(np.isfinite(square).sum(axis=1).min()))
    near = np.argpartition(square, count - 1, axis=1)[:, :count]
    square = np.take_along_axis(square, near, axis=1)
    size = np.sqrt(square.max(axis=1))[:, None, None]
    x, y = np.moveaxis((points[near] - places[:, None]) / size, -1, 0)
    terms = [np.ones_like(x), x, y, x * x, x * y, y * y][: 6 if count >= _QUADRATIC_FROM else 3]
    weight = 1.0 / (0.05 + square / size[:, 0] ** 2)[..., None]
    design = np.stack(terms, axis=-1)
    normal = np.swapaxes(design, 1, 2) @ (weight * design)
    right = np.swapaxes(design, 1, 2) @ (weight * moved[near])
    ridge = 1e-6 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(len(terms))
    return np.asarray(np.linalg.solve(normal + ridge, right)[:, 0])


def fit_motion_model(
    rest_px: FloatArray, moved_px: Sequence[FloatArray] | FloatArray, least_noise_px: float = _NOISE_PX
) -> MotionModel:
    """Fit the modes of motion to displacements (n, m, 2) of markers (m, 2) from rest, px.

    `least_noise_px` is the minimum standard deviation of a blob coordinate.
    """
    flat = np.array(moved_px, float).reshape(len(moved_px), -1)
    mean = flat.mean(axis=0)
    _, values, rows = np.linalg.svd(flat - mean, full_matrices=False)
    kept = max(1, min(_MOST, len(flat) // 3))
    left = float((values[kept:] ** 2).sum()) / max(flat.size, 1)
    modes = (values[:kept, None] / np.sqrt(len(flat)) * rows[:kept]).reshape(-1, *rest_px.shape)
    return MotionModel(rest_px, modes, mean.reshape(rest_px.shape), max(float(np.sqrt(left)), least_noise_px))
