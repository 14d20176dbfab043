"""How far a camera has crept, from what single images say of it: a Kalman filter for each way that it can move.

What image t tells of one way, in px rms of the dots that it moves, is

    told(t) = crept(t) + first + noise(t),

with the noise of the image at rest, from which all motion is counted, as `first`: it stays, and is no creep. Creeping
begins at nothing and goes on at a pace that hardly changes from image to image (R. E. Kalman, J. Basic Eng. 82, 1960,
35-45; place and pace as in tracking).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from palpate.core import FloatArray

_PACE_PX = 1e-4
"""Standard deviation of the pace at the beginning, px rms an image."""
_CHANGE_PX = 2e-6
"""The same of its change from one image to the next."""
_UNTOLD_PX = 0.05
"""Noise of a way, px rms, above which it is not followed: images do not tell it from something else."""
_STEP = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
_TOLD = np.array([1.0, 0.0, 1.0])


class Creep(NamedTuple):
    """What is known after some images, way by way.

    Attributes
    ----------
    mean
        (k, 3) px rms: crept, pace, first.
    covariance
        (k, 3, 3) of these.
    """

    mean: FloatArray
    covariance: FloatArray


class CreepFilter:
    """Follows the motion of a camera.

    Parameters
    ----------
    noise
        (k, k) covariance of the motion that one image tells where nothing moves.
    metric
        (k, k) from a motion m to the mean squared distance by which it moves the dots, px²: mᵀ metric m.
    """

    def __init__(self, noise: FloatArray, metric: FloatArray) -> None:
        # ways that move the dots by 1 px rms each, whose noise is independent
        variance, ways = eigh(metric @ noise @ metric, metric)
        told = variance <= _UNTOLD_PX**2
        self._variance, self._ways = variance[told], ways[:, told]
        self._to_ways = self._ways.T @ metric

    def begin(self) -> Creep:
        """What is known before any image but that at rest."""
        covariance = np.zeros((len(self._variance), 3, 3))
        covariance[:, 1, 1], covariance[:, 2, 2] = _PACE_PX**2, self._variance
        return Creep(np.zeros((len(self._variance), 3)), covariance)

    def moved(self, creep: Creep) -> FloatArray:
        """By how much (k,) the camera has crept."""
        return np.asarray(self._ways @ creep.mean[:, 0], float)

    def knocked(self, creep: Creep, told: FloatArray, least_px: float, sure: float) -> bool:
        """Whether an image tells a motion (k,) that is no creep.

        That is one by at least so many px rms from what was expected, of which noise alone does not tell: the sum of
        squares of all ways over their variances is so many of its standard deviations beyond its mean.
        """
        mean, covariance = _ahead(creep)
        off = self._to_ways @ told - mean @ _TOLD
        square = np.sum(off**2 / (covariance @ _TOLD @ _TOLD + self._variance))
        return bool(np.sum(off**2) > least_px**2 and square > len(off) + sure * np.sqrt(2.0 * len(off)))

    def follow(self, creep: Creep, told: FloatArray) -> Creep:
        """What is known after another image, which tells a motion (k,)."""
        mean, covariance = _ahead(creep)
        shared = covariance @ _TOLD
        gain = shared / (shared @ _TOLD + self._variance)[:, None]
        off = self._to_ways @ told - mean @ _TOLD
        return Creep(mean + gain * off[:, None], covariance - gain[:, :, None] * shared[:, None, :])


def _ahead(creep: Creep) -> Creep:
    """What is known of the next image before it is seen."""
    covariance = _STEP @ creep.covariance @ _STEP.T
    covariance[:, 1, 1] += _CHANGE_PX**2
    return Creep(creep.mean @ _STEP.T, covariance)
