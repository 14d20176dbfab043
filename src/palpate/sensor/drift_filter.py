"""How far a camera has crept, from what single images say of it: a Kalman filter for each way that it can move.

What image t tells of one way, in px rms of the dots that it moves, is

    told(t) = crept(t) + first + noise(t),

with the noise of the image at rest, from which all motion is counted, as `first`: it stays, and is no drift. Creeping
begins at nothing and goes on at a pace that hardly changes (R. E. Kalman, J. Basic Eng. 82, 1960, 35-45). The pace is
a random walk in time, so that a step of any length has the covariance of many short ones (Y. Bar-Shalom, X. R. Li,
T. Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section 6.2), and a drift is followed
alike at every frame rate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from palpate.core import FloatArray

FRAME_S = 0.05
"""Time from one image to the next where no clock tells it, s: 20 images a second."""
LONGEST_S = 60.0
"""Longest step, s: after a longer pause the camera is expected where it would be after this one, to within 0.06 px;
after twice as long 0.15 px, which a knock may hide in."""
_PACE_PX_S = 1e-4 / FRAME_S
"""Standard deviation of the pace at the beginning, px rms/s; that of a rig in a warming room, 7 px an hour."""
_CHANGE_PX_S = 2e-6 / FRAME_S**1.5
"""The same of its change within a second, px rms/s^1.5: 2e-6 px an image from one to the next of `FRAME_S`."""
_UNTOLD_PX = 0.05
"""Noise of a way, px rms, above which it is not followed: images do not tell it from something else."""
_MEASURED = np.array([1.0, 0.0, 1.0])


class CameraDrift(NamedTuple):
    """What is known after some images, way by way.

    Attributes
    ----------
    mean
        (k, 3): crept (px rms), pace (px rms/s), first (px rms).
    covariance
        (k, 3, 3) of these.
    """

    mean: FloatArray
    covariance: FloatArray


class DriftFilter:
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

    def initial(self) -> CameraDrift:
        """What is known before any image but that at rest."""
        covariance = np.zeros((len(self._variance), 3, 3))
        covariance[:, 1, 1], covariance[:, 2, 2] = _PACE_PX_S**2, self._variance
        return CameraDrift(np.zeros((len(self._variance), 3)), covariance)

    def motion(self, drift: CameraDrift) -> FloatArray:
        """By how much (k,) the camera has crept."""
        return np.asarray(self._ways @ drift.mean[:, 0], float)

    def is_jump(self, drift: CameraDrift, measured: FloatArray, step_s: float, least_px: float, sure: float) -> bool:
        """Whether an image, a time in s after the last that was followed, tells a motion (k,) that is no drift.

        That is one by at least so many px rms from what was expected, of which noise alone does not tell: the sum of
        squares of all ways over their variances is so many of its standard deviations beyond its mean.
        """
        mean, covariance = _ahead(drift, step_s)
        off = self._to_ways @ measured - mean @ _MEASURED
        square = np.sum(off**2 / (covariance @ _MEASURED @ _MEASURED + self._variance))
        return bool(np.sum(off**2) > least_px**2 and square > len(off) + sure * np.sqrt(2.0 * len(off)))

    def update(self, drift: CameraDrift, measured: FloatArray, step_s: float = FRAME_S) -> CameraDrift:
        """What is known after another image, a time in s after the last one followed, which tells a motion (k,)."""
        mean, covariance = _ahead(drift, step_s)
        shared = covariance @ _MEASURED
        gain = shared / (shared @ _MEASURED + self._variance)[:, None]
        off = self._to_ways @ measured - mean @ _MEASURED
        return CameraDrift(mean + gain * off[:, None], covariance - gain[:, :, None] * shared[:, None, :])


def _ahead(drift: CameraDrift, step_s: float) -> CameraDrift:
    """What is known of the next image, a time in s later, before it is seen."""
    step = np.eye(3)
    step[0, 1] = step_s
    covariance = step @ drift.covariance @ step.T
    walk = np.array([[step_s**3 / 3.0, step_s**2 / 2.0], [step_s**2 / 2.0, step_s]])
    covariance[:, :2, :2] += _CHANGE_PX_S**2 * walk
    return CameraDrift(drift.mean @ step.T, covariance)
