"""Kalman filter of the camera drift, one for each independent mode of the camera's motion.

The measurement of one mode in image t, in px rms of the marker displacement, is

    measured(t) = drift(t) + first + noise(t),

where `first` is the constant noise of the rest image, relative to which all motion is measured; it is no drift. The
drift begins at zero, and its rate changes slowly (R. E. Kalman, J. Basic Eng. 82, 1960, 35-45). The rate is a random
walk in time, so that one long step has the covariance of many short ones (Y. Bar-Shalom, X. R. Li, T. Kirubarajan,
Estimation with Applications to Tracking and Navigation, 2001, section 6.2), and the result does not depend on the
frame rate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from palpate.core import FloatArray

FRAME_S = 0.05
"""Time between two images without a clock, s: 20 images per second."""
LONGEST_S = 60.0
"""Longest step, s; after a longer pause, the state is predicted for this step.

The camera is then predicted within 0.06 px; after a pause twice as long within 0.15 px, which can hide a jump.
"""
_PACE_PX_S = 1e-4 / FRAME_S
"""Initial standard deviation of the drift rate, px rms/s: 7 px per hour. By hand."""
_CHANGE_PX_S = 2e-6 / FRAME_S**1.5
"""Standard deviation of the rate's change, px rms/s^1.5: 2e-6 px per image. By hand."""
_UNTOLD_PX = 0.05
"""Noise of a mode, px rms, above which it is not tracked, because images do not determine it. By hand."""
_MEASURED = np.array([1.0, 0.0, 1.0])


class CameraDrift(NamedTuple):
    """State of the drift filter, by mode.

    `mean` (k, 3) contains drift (px rms), rate (px rms/s) and first (px rms), and `covariance` (k, 3, 3) is theirs.
    """

    mean: FloatArray
    covariance: FloatArray


class DriftFilter:
    """Tracker of the slow motion of a camera.

    `noise` (k, k) is the covariance of the motion measured in one image; mᵀ `metric` m is the mean squared marker
    displacement of a motion m, px².
    """

    def __init__(self, noise: FloatArray, metric: FloatArray) -> None:
        # ways that move the dots by 1 px rms each, whose noise is independent
        variance, ways = eigh(metric @ noise @ metric, metric)
        told = variance <= _UNTOLD_PX**2
        self._variance, self._ways = variance[told], ways[:, told]
        self._to_ways = self._ways.T @ metric

    def initial(self) -> CameraDrift:
        """Return the state before any image but the rest images."""
        covariance = np.zeros((len(self._variance), 3, 3))
        covariance[:, 1, 1], covariance[:, 2, 2] = _PACE_PX_S**2, self._variance
        return CameraDrift(np.zeros((len(self._variance), 3)), covariance)

    def motion(self, drift: CameraDrift) -> FloatArray:
        """Return the estimated drift (k,) of the camera."""
        return np.asarray(self._ways @ drift.mean[:, 0], float)

    def is_jump(self, drift: CameraDrift, measured: FloatArray, step_s: float, least_px: float, sure: float) -> bool:
        """Test whether a motion (k,) measured `step_s` after the last tracked image is a jump, not drift.

        It is a jump if it deviates from the prediction by more than `least_px` px rms and the deviation is
        significant: the sum of squares of all modes over their variances exceeds its mean by more than `sure` of its
        standard deviations.
        """
        mean, covariance = _ahead(drift, step_s)
        off = self._to_ways @ measured - mean @ _MEASURED
        square = np.sum(off**2 / (covariance @ _MEASURED @ _MEASURED + self._variance))
        return bool(np.sum(off**2) > least_px**2 and square > len(off) + sure * np.sqrt(2.0 * len(off)))

    def update(self, drift: CameraDrift, measured: FloatArray, step_s: float = FRAME_S) -> CameraDrift:
        """Return the state updated by a motion (k,) measured `step_s` after the last tracked image."""
        mean, covariance = _ahead(drift, step_s)
        shared = covariance @ _MEASURED
        gain = shared / (shared @ _MEASURED + self._variance)[:, None]
        off = self._to_ways @ measured - mean @ _MEASURED
        return CameraDrift(mean + gain * off[:, None], covariance - gain[:, :, None] * shared[:, None, :])


def _ahead(drift: CameraDrift, step_s: float) -> CameraDrift:
    """Predict the state after a time step, s."""
    step = np.eye(3)
    step[0, 1] = step_s
    covariance = step @ drift.covariance @ step.T
    walk = np.array([[step_s**3 / 3.0, step_s**2 / 2.0], [step_s**2 / 2.0, step_s]])
    covariance[:, :2, :2] += _CHANGE_PX_S**2 * walk
    return CameraDrift(drift.mean @ step.T, covariance)
