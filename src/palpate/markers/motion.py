"""How markers move together: the model that predicts them and stands in for those that are lost.

With images of a simulated press the model is their mean motion and its main directions (principal components), fitted
to the markers that are seen with a ridge of the noise over the spread of each direction. Without them it is the
quadratic function of the place at rest that fits the motion of the nearest seen markers: right for any design.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray

_NEIGHBOURS = 14
_QUADRATIC_FROM = 9
"""Neighbours from which on the smooth motion is a quadratic function of the place at rest, else a linear one."""
_NOISE_PX = 0.3
"""Expected misfit of a mode model: noise of a dot and what the modes leave out."""


@dataclass(frozen=True, eq=False)
class MotionModel:
    """Joint motion of m markers from rest.

    Attributes
    ----------
    rest_px
        (m, 2) markers at rest.
    modes_px
        (k, m, 2) directions of motion, each as long as its standard deviation; `None` for any smooth motion.
    """

    rest_px: FloatArray
    modes_px: FloatArray | None = None

    def fill(self, seen_px: FloatArray, found: BoolArray) -> FloatArray:
        """Estimate all markers from those that are seen.

        Parameters
        ----------
        seen_px
            (m, 2) positions; those that are not found are not looked at.
        found
            (m,) which are.

        Returns
        -------
        ndarray
            (m, 2) estimates of all, seen or not.
        """
        moved = (seen_px - self.rest_px)[found]
        if self.modes_px is None:
            return self.rest_px + self._smooth(moved, found)
        modes = self.modes_px[:, found].reshape(len(self.modes_px), -1)
        normal = modes @ modes.T + _NOISE_PX**2 * np.eye(len(modes))
        weights = np.linalg.solve(normal, modes @ moved.reshape(-1))
        estimate: FloatArray = self.rest_px + np.tensordot(weights, self.modes_px, axes=1)
        if found.sum() >= 4:  # what the modes leave over is smooth too
            left = (seen_px - estimate)[found]
            if not found.all():
                estimate = estimate + self._smooth(left, found)
        return estimate

    def _smooth(self, moved: FloatArray, found: BoolArray) -> FloatArray:
        if found.sum() < 4:
            return np.broadcast_to(moved.mean(axis=0) if len(moved) else 0.0, self.rest_px.shape).copy()
        result = np.empty_like(self.rest_px)
        result[found] = moved
        if found.all():
            return result
        seen, lost = self.rest_px[found], self.rest_px[~found]
        square = ((lost[:, None] - seen[None]) ** 2).sum(axis=-1)
        count = min(_NEIGHBOURS, len(seen))
        near = np.argpartition(square, count - 1, axis=1)[:, :count]
        square = np.take_along_axis(square, near, axis=1)
        size = np.sqrt(square.max(axis=1))[:, None, None]
        x, y = np.moveaxis((seen[near] - lost[:, None]) / size, -1, 0)
        terms = [np.ones_like(x), x, y, x * x, x * y, y * y][: 6 if count >= _QUADRATIC_FROM else 3]
        weight = 1.0 / (0.05 + square / size[:, 0] ** 2)[..., None]
        design = np.stack(terms, axis=-1)
        normal = np.swapaxes(design, 1, 2) @ (weight * design)
        right = np.swapaxes(design, 1, 2) @ (weight * moved[near])
        ridge = 1e-6 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(len(terms))
        result[~found] = np.linalg.solve(normal + ridge, right)[:, 0]
        return result


def fit_motion_model(rest_px: FloatArray, images_px: FloatArray, share: float = 0.9999) -> MotionModel:
    """The mode model of simulated images.

    Parameters
    ----------
    rest_px
        (m, 2) markers at rest.
    images_px
        (n, m, 2) the same markers in simulated images.
    share
        Share of the squared motion that the modes hold.
    """
    moved = (images_px - rest_px).reshape(len(images_px), -1)
    _, size, rows = np.linalg.svd(moved, full_matrices=False)
    held = np.cumsum(size**2) / np.sum(size**2)
    count = int(np.searchsorted(held, share)) + 1
    deviation = size[:count] / np.sqrt(len(images_px))
    return MotionModel(rest_px, (deviation[:, None] * rows[:count]).reshape(count, *rest_px.shape))
