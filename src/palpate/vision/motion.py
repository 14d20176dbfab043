"""Joint motion of markers: the model that predicts those that are lost, or have no number yet.

The motion of one sensor is mean + Σ c_i d_i with coordinates c of unit variance (probabilistic principal components,
Tipping and Bishop 1999, doi 10.1111/1467-9868.00196). The most probable coordinates are fitted to the markers that
are seen, those that fit badly with a smaller weight; lost markers have the place that the seen ones give them. Unlike
a smooth field this model has kinks, where the sensor has them. Without images of the sensor the motion is the
quadratic function of the place at rest that fits the nearest seen markers: right for any design.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from palpate.core import BoolArray, FloatArray

_NEIGHBOURS, _QUADRATIC_FROM = 14, 9
"""Neighbours to which a smooth motion is fitted, and from which on it is quadratic, else linear."""
_NOISE_PX = 0.3
"""Expected misfit of a fitted model, px, at least: noise of a blob and what the modes leave out."""
_MOST, _ROUNDS = 48, 3
"""Largest number of modes, at most a third of the images; rounds of weighting."""


@dataclass(frozen=True, eq=False)
class MotionModel:
    """Joint motion of m markers from rest.

    Attributes
    ----------
    rest_px
        (m, 2) markers at rest.
    modes_px
        (k, m, 2) directions of motion, each as long as its standard deviation; `None` for any smooth motion.
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
        """Most probable motion (m, 2), px, given displacements (m, 2) of the markers that are found (m,)."""
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
        """Positions (m, 2) of all markers, px, estimated from those (m, 2) of the markers that are found (m,).

        What the modes leave over is smooth too, and is added.
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
    """Smooth motion at places, fitted to that of the nearest points; a point at a place is left out there.

    Parameters
    ----------
    points, moved
        (n, 2) points at rest and their motion, px.
    places
        (k, 2) places at rest, px.

    Returns
    -------
    ndarray
        (k, 2) motion, px: by the moving least squares of a quadratic polynomial; the mean for fewer than four points.
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
    """The modes of motion of images whose markers are known.

    Parameters
    ----------
    rest_px
        (m, 2) markers at rest.
    moved_px
        (n, m, 2) displacements of the markers in images.
    least_noise_px
        Standard deviation of a coordinate of a blob.
    """
    flat = np.array(moved_px, float).reshape(len(moved_px), -1)
    mean = flat.mean(axis=0)
    _, values, rows = np.linalg.svd(flat - mean, full_matrices=False)
    kept = max(1, min(_MOST, len(flat) // 3))
    left = float((values[kept:] ** 2).sum()) / max(flat.size, 1)
    modes = (values[:kept, None] / np.sqrt(len(flat)) * rows[:kept]).reshape(-1, *rest_px.shape)
    return MotionModel(rest_px, modes, mean.reshape(rest_px.shape), max(float(np.sqrt(left)), least_noise_px))
