"""Predicted posterior of a unit after calibration presses, before any unit is built."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from palpate.calibration.calibration_press import CalibrationPress, RobotUncertainty
from palpate.calibration.groups import sum_by_group
from palpate.calibration.identify import UnitFit
from palpate.calibration.mounting import Mounting
from palpate.calibration.unit_model import UnitModel
from palpate.core import FloatArray, IntArray


class PredictedPosterior(NamedTuple):
    """Predicted uncertainty of a unit after calibration presses.

    `covariance` (15, 15), of `UNIT_PARAMETERS` and `MOUNTING_PARAMETERS`, is that of the fit; `exact_twin_covariance`
    is the covariance without twin error, by noise, robot and prior alone; `rest_marker_gain` (15, 2 m) is the
    response of the estimate to an error (px) of each rest-marker coordinate, which is in all images.
    """

    covariance: FloatArray
    exact_twin_covariance: FloatArray
    rest_marker_gain: FloatArray


def predict_posterior(
    model: UnitModel,
    mounting: Mounting,
    presses: Sequence[tuple[CalibrationPress, float]],
    noise_px: float | FloatArray,
    robot: RobotUncertainty,
) -> PredictedPosterior:
    """Predict the uncertainty of a unit after calibration presses, each with its 1/µ.

    The unit is assumed equal to the means of `model` and `mounting`. `noise_px` is that of each marker if (m,).
    Without any press, the uncertainty is unchanged.
    """
    if not presses:
        none = np.zeros((len(mounting.covariance), 2 * len(model.visible)))
        return PredictedPosterior(mounting.covariance, mounting.covariance, none)
    fit = UnitFit(model, [press for press, _ in presses], noise_px, robot)
    values = np.zeros(fit.size)
    values[fit.friction_slice] = [slip for _, slip in presses]
    found = fit.assemble(model, mounting, values)
    information = fit.information(mounting)
    inverse: FloatArray = np.asarray(np.linalg.inv(found.normal + information), float)
    by_dot, kept = inverse @ found.common, slice(fit.shared)
    by_chance = (
        inverse @ (information + found.gradient_noise) @ inverse + by_dot * np.repeat(fit.noise**2, 2) @ by_dot.T
    )
    return PredictedPosterior(fit.covariance(found, information)[kept, kept], by_chance[kept, kept], by_dot[kept])


class PressInformation(NamedTuple):
    """Information of calibration presses, by group of markers.

    Attributes
    ----------
    normal
        (g, n, n) information about `UNIT_PARAMETERS`, `MOUNTING_PARAMETERS` and the parameters of each press.
    by_dot
        (m, 2, n) derivative of the gradient by an error of each coordinate that is common to all images.
    own_prior
        (n - 15,) prior precision of the parameters of each press.
    common_variance
        (g,) variance of such an error, px².
    """

    normal: FloatArray
    by_dot: FloatArray
    own_prior: FloatArray
    common_variance: FloatArray


def press_information(
    model: UnitModel,
    mounting: Mounting,
    presses: Sequence[tuple[CalibrationPress, float]],
    group: IntArray,
    noise_px: FloatArray,
    robot: RobotUncertainty,
) -> PressInformation:
    """Return the information of calibration presses of a unit as modelled, by group (m,) of markers.

    The noise (g,) is that of every group; all else is as for `predict_posterior`.
    """
    fit, groups = UnitFit(model, [press for press, _ in presses], noise_px[group], robot), int(group.max()) + 1
    variance = fit.variance[:, None, None]
    normal = np.zeros((groups, fit.size, fit.size))
    alike = np.zeros((len(group), 2, fit.size))
    for k, (press, slip) in enumerate(presses):
        own = fit.shared + fit.own * k
        columns = np.array([*range(fit.shared), *range(own, own + fit.own)])
        for pose in press.poses:
            _, slopes = fit.predict(model, mounting, pose, np.array([slip, *[0.0] * (fit.own - 1)]))
            rows = np.nan_to_num(slopes)
            normal[np.ix_(np.arange(groups), columns, columns)] += sum_by_group(rows, rows / variance, group)
            alike[..., columns] += rows / variance
    prior = np.diag(fit.information(mounting))[fit.shared :]
    shared = np.zeros(groups)
    shared[group] = fit.shared_variance
    return PressInformation(normal, alike, prior, shared)
