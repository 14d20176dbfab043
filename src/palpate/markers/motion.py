"""How markers move together: the model that predicts them and stands in for those that are lost.

With images of a simulated press the model is their mean motion and its main directions (principal components), fitted
to the markers that are seen with a ridge of the noise over the spread of each direction. Without them it is the thin
plate spline through the motion of the nearest seen markers: smooth, and right for any design.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

Array = NDArray[np.float64]
_NEIGHBOURS = 18
_NOISE_PX = 0.3
"""Expected misfit of a mode model: noise of a dot and what the modes leave out."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Joint motion of m markers from rest.

    Attributes
    ----------
    rest_px
        (m, 2) markers at rest.
    modes_px
        (k, m, 2) directions of motion, each as long as its standard deviation; `None` for any smooth motion.
    """

    rest_px: Array
    modes_px: Array | None = None

    def fill(self, seen_px: Array, found: NDArray[np.bool_]) -> Array:
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
        estimate: Array = self.rest_px + np.tensordot(weights, self.modes_px, axes=1)
        if found.sum() >= 4:  # what the modes leave over is smooth too
            left = (seen_px - estimate)[found]
            if not found.all():
                estimate = estimate + self._smooth(left, found)
        return estimate

    def _smooth(self, moved: Array, found: NDArray[np.bool_]) -> Array:
        if found.sum() < 4:
            return np.broadcast_to(moved.mean(axis=0) if len(moved) else 0.0, self.rest_px.shape).copy()
        result = np.empty_like(self.rest_px)
        result[found] = moved
        if not found.all():
            spline = RBFInterpolator(self.rest_px[found], moved, neighbors=min(_NEIGHBOURS, int(found.sum())))
            result[~found] = spline(self.rest_px[~found])
        return result


def learn_motion(rest_px: Array, images_px: Array, share: float = 0.9999) -> Motion:
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
    return Motion(rest_px, (deviation[:, None] * rows[:count]).reshape(count, *rest_px.shape))
