"""What known presses would tell about a unit of a design, before any is built."""

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
    """What presses would leave unknown of a unit.

    `covariance` is (15, 15), of `UNIT_PARAMETERS` and `MOUNTING_PARAMETERS`, as it would be believed;
    `exact_twin_covariance` the same if the twin were right, by noise, robot and what is not known beforehand alone;
    `rest_marker_gain` (15, 2 m) what an error (px) of each coordinate of the dots at rest, which is in all images, is
    taken for.
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
    """What presses of a unit that is as believed would leave unknown of it.

    Parameters
    ----------
    model, mounting
        What is known of the unit before; the presses are what it shows.
    presses
        Known presses, each with its 1/µ; without any, nothing is learnt.
    noise_px, robot
        As for `identify`; noise also (m,) of each dot.
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
    """What known presses tell, by group of dots.

    Attributes
    ----------
    normal
        (g, n, n) information about `UNIT_PARAMETERS`, `MOUNTING_PARAMETERS` and what is each press's own.
    by_dot
        (m, 2, n) how an error of each coordinate that is alike in all of their images enters the gradient.
    own_prior
        (n - 15,) precision beforehand of what is each press's own.
    common_variance
        (g,) of such an error, px².
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
    """Information of known presses of a unit that is as believed, apart for every group (m,) of its dots.

    The other parameters are those of `predict_posterior`, the noise (g,) that of every group.
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
