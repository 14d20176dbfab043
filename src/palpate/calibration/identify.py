"""Identification of a built unit from calibration presses: unit parameters and mounting on the robot.

The robot knows the pose of a calibration press. The skin is mounted with a small tilt and rotation, and its depth 0
differs from that of the robot (`palpate.calibration.mounting`). Unit, mounting, and the friction and robot error of
every press are fitted together to all markers of all images, each with its prior. A Gauss-Newton iteration finds the
maximum of the posterior; the curvature there gives the covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from palpate.calibration.calibration_press import CalibrationPress, RobotUncertainty
from palpate.calibration.deviation import IMPERFECTIONS
from palpate.calibration.fit_pose import MAX_INVERSE_FRICTION, PoseFitter
from palpate.calibration.force import ScalarEstimate, prior_stiffness_scale
from palpate.calibration.mounting import MOUNTING_PARAMETERS, Mounting, mounting_prior_sd, prior_mounting
from palpate.calibration.noise import robust_weights
from palpate.calibration.scale import model_px, pixel_scale
from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.unit_model import LEAST_SD, UNIT_PARAMETERS, UnitModel, UnitPosterior, unit_prior_sd
from palpate.core import FloatArray, IntArray, PalpateError
from palpate.core.state import State
from palpate.design import TILT_SPACE, Skin
from palpate.surrogate import LATERAL

_TWIN_SD = {"thickness": 0.011, "depth_zero": 0.011, "inverse_friction": 0.012}
"""Standard deviations of the twin error (mm, mm, 1/µ), of 20 simulated units.

The units had other meshes and stiffening. The error is common to all markers of all images; marker noise contributes
a tenth of it. These and the constants below hold for skin and image of the sizes in `palpate.calibration.scale`.
"""
_LENS_SD = {"distance": 0.19, "focal": 0.0035, "k1": 0.0145}
"""Additional standard deviations of these parameters (mm, ratios), measured on the same units.

Together they determine the scale of an image, and only this scale is observable; poses do not depend on its division
among them.
"""
_DRIFT_PX = 0.12
"""Additional twin error if the wall moves laterally: higher-order terms, largest if it slips. By hand."""
_FIRST, _ITERATIONS = 4, 16
"""Iterations without unit parameters (the robot's zero may be far off), and their maximum. By hand."""
_SMALL = 1e-3
"""Change over the standard deviation below which the fit ends. By hand."""
_WRONG = 9.0
"""Reduced chi-square above which the presses are rejected. By hand."""
_FAR = 5.0
"""Deviation in standard deviations above which a robot pose or a unit parameter is rejected. By hand."""


class UnitEstimate(NamedTuple):
    """Mean (15,) and covariance (15, 15) of `UNIT_PARAMETERS` and `MOUNTING_PARAMETERS`."""

    mean: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class IdentificationResult:
    """Result of the identification of a unit.

    Attributes
    ----------
    posterior, mounting
        Posterior of the unit, and mounting on the robot.
    inverse_frictions, inverse_frictions_sd
        (p,) 1/µ of every press.
    misfit
        Reduced chi-square; about 1.
    robot_error
        (p, 3) fitted error of the robot's poses, over its standard deviation.
    scale
        Stiffness relative to the design.
    estimate
        Estimate of the parameters; `posterior` and `mounting` have the values with which the twin explains the images
        best.
    left_out
        Deviations that the twin does not model, which are not estimated.
    """

    posterior: UnitPosterior
    mounting: Mounting
    inverse_frictions: FloatArray
    inverse_frictions_sd: FloatArray
    misfit: float
    robot_error: FloatArray
    scale: ScalarEstimate
    estimate: UnitEstimate
    left_out: tuple[str, ...] = ()

    def rows(self, tolerance: ToleranceSpec) -> list[dict[str, Any]]:
        """Return name, unit, mean, sd and prior sd (`before`) of every parameter and of 1/µ of every press."""
        units = {part: item.unit for item in IMPERFECTIONS for part in item.parts} | {"stiffness": "1"}
        before = [*unit_prior_sd(tolerance), *mounting_prior_sd(tolerance), prior_stiffness_scale(tolerance).sd]
        means, names = [*self.estimate.mean, self.scale.value], (*UNIT_PARAMETERS, *MOUNTING_PARAMETERS, "stiffness")
        spread = [*np.sqrt(np.diag(self.estimate.covariance)), self.scale.sd]
        found: list[dict[str, Any]] = [
            {"name": name, "unit": units[name], "mean": float(mean), "sd": float(sd), "before": float(first)}
            for name, mean, sd, first in zip(names, means, spread, before, strict=True)
            if name not in self.left_out
        ]
        prior = {"unit": "1", "before": tolerance.inverse_friction_prior[1]}
        for k, (mean, sd) in enumerate(zip(self.inverse_frictions, self.inverse_frictions_sd, strict=True), start=1):
            found.append({"name": f"1/friction of press {k}", "mean": float(mean), "sd": float(sd), **prior})
        return found


def identify(
    model: UnitModel, presses: Sequence[CalibrationPress], noise_px: float, robot: RobotUncertainty | None = None
) -> IdentificationResult:
    """Identify a unit and its mounting from calibration presses.

    Parameters
    ----------
    model
        Model of the unit after its rest image (`infer_from_rest`).
    presses
        At least one; three in different directions determine the mounting.
    noise_px
        Standard deviation of a marker coordinate in one image.
    robot
        Uncertainty of the robot's poses.

    Raises
    ------
    PalpateError
        If there is no press, or the presses do not fit one unit of this design.
    """
    if not presses:
        raise PalpateError(
            "No calibration press was given.",
            "Record at least one press, better three, at poses measured by the robot.",
            code="calibration-press-missing",
        )
    return UnitFit(model, presses, noise_px, robot or RobotUncertainty()).solve(model)


def twin_error_sd(skin: Skin, left_out: Sequence[str] = ()) -> FloatArray:
    """Twin error (15,) in `UNIT_PARAMETERS` and `MOUNTING_PARAMETERS`; 0 if the twin leaves it out."""
    names = (*UNIT_PARAMETERS, *MOUNTING_PARAMETERS)
    return skin.size * np.array([0.0 if name in left_out else _TWIN_SD.get(name, 0.0) for name in names])


def _lens_sd(skin: Skin) -> FloatArray:
    """Return the additional standard deviations (11,) of `UNIT_PARAMETERS` by the image scale."""
    sizes = {"distance": skin.size}
    return np.array([sizes.get(name, 1.0) * _LENS_SD.get(name, 0.0) for name in UNIT_PARAMETERS])


class NormalEquations(NamedTuple):
    """Normal equations of all markers: `normal` (n, n) and `gradient` (n,), over the variance.

    `gradient_noise` (n, n) is the covariance of the gradient by image noise alone, `common` (n, 2 m) its derivative
    by each coordinate (px) of the markers at rest, and `misfit` the reduced chi-square.
    """

    normal: FloatArray
    gradient: FloatArray
    gradient_noise: FloatArray
    common: FloatArray
    misfit: float


class UnitFit:
    """Fit of calibration presses. Parameters: unit (11), mounting (4), then those of every press.

    The parameters of a press are 1/µ and the robot's error in rx, ry and depth. If lateral motion is in the
    tolerance, they also are its three components at the twin's maximum depth.
    """

    def __init__(
        self,
        model: UnitModel,
        presses: Sequence[CalibrationPress],
        noise_px: float | FloatArray,
        robot: RobotUncertainty,
    ) -> None:
        self.twin, self.presses = model.marker_twin.twin, presses
        self.noise = noise = np.broadcast_to(np.asarray(noise_px, float), len(model.visible))
        self.noise_px = float(np.median(noise))
        self.robot_sd = np.array([robot.tilt_deg, robot.tilt_deg, robot.depth])
        self.drift_sd = np.array(model.tolerance.lateral_sd)
        self.drifts = bool(self.drift_sd.any())
        skin, camera = model.marker_twin.twin.skin, model.posterior.nominal
        drift_px = _DRIFT_PX * pixel_scale(skin, camera)
        self.shared_variance = noise**2 + model_px(skin, camera) ** 2 + self.drifts * drift_px**2
        self.variance = noise**2 + self.shared_variance
        self.shared, self.own = len(UNIT_PARAMETERS) + 4, 7 if self.drifts else 4
        self.size = self.shared + self.own * len(presses)
        self.has_friction = len(self.twin.inverse_frictions) > 1
        self.slip_sd = model.tolerance.inverse_friction_prior[1]
        self.friction_slice = slice(self.shared, None, self.own)
        self.twin_sd = np.zeros(self.size)
        self.twin_sd[: self.shared] = twin_error_sd(skin, self.twin.left_out)
        self.twin_sd[self.friction_slice] = _TWIN_SD["inverse_friction"]

    def solve(self, model: UnitModel) -> IdentificationResult:
        """Iterate to the maximum of the posterior."""
        belief, prior = model.posterior, prior_mounting(model.posterior, model.tolerance)
        information = self.information(prior)
        before, seated = np.zeros(self.size), slice(len(UNIT_PARAMETERS), self.shared)
        before[self.friction_slice] = (
            model.tolerance.inverse_friction_prior[0] if self.has_friction else self.twin.inverse_frictions[0]
        )
        values, now = self._begin(model, before), belief
        mounting = Mounting(State(MOUNTING_PARAMETERS, values[seated]), prior.covariance)
        for iteration in range(_ITERATIONS):
            model = model.with_posterior(now)
            found = self.assemble(model, mounting, values)
            normal = found.normal + information
            gradient = found.gradient - information @ (values - before)
            free = self._mounted if iteration < _FIRST else np.arange(self.size)
            spread, change = np.sqrt(np.diag(np.linalg.inv(normal))), np.zeros(self.size)
            change[free] = np.linalg.solve(normal[np.ix_(free, free)], gradient[free])
            values = values + change
            values[self.friction_slice] = np.clip(
                values[self.friction_slice],
                self.twin.inverse_frictions[0],
                min(self.twin.inverse_frictions[-1], MAX_INVERSE_FRICTION),
            )
            now = replace(belief, mean=belief.mean.add(UNIT_PARAMETERS, values[: len(UNIT_PARAMETERS)]))
            mounting = Mounting(State(MOUNTING_PARAMETERS, values[seated]), prior.covariance)
            if iteration > _FIRST and (np.abs(change) < _SMALL * spread).all():
                break
        covariance = self.covariance(found, information)
        off = values[self.shared :].reshape(-1, self.own)[:, 1:4] / self.robot_sd
        believable = np.hypot(unit_prior_sd(model.tolerance), _lens_sd(self.twin.skin))
        _refuse(now.mean.values / believable, found.misfit, off)
        shared = covariance[: self.shared, : self.shared]
        return IdentificationResult(
            posterior=replace(now, covariance=shared[: len(UNIT_PARAMETERS), : len(UNIT_PARAMETERS)]),
            mounting=replace(mounting, covariance=shared),
            inverse_frictions=values[self.friction_slice],
            inverse_frictions_sd=np.sqrt(np.diag(covariance)[self.friction_slice]),
            misfit=found.misfit,
            robot_error=off,
            scale=prior_stiffness_scale(model.tolerance),
            estimate=self._estimate(belief, found, information, values - before),
            left_out=self.twin.left_out,
        )

    def _begin(self, model: UnitModel, before: FloatArray) -> FloatArray:
        """Return starting values of mounting, friction and lateral motion, by pose fits of the single images."""
        values, off, deepest = before.copy(), [], float(self.twin.depths_mm[-1])
        for k, press in enumerate(self.presses):
            fitter = PoseFitter(model, self.noise_px)
            fits = [fitter.fit(pixels) for pixels in press.pixels]
            own = self.shared + self.own * k
            off += [pose - fit.pose for pose, fit in zip(press.poses, fits, strict=True)]
            if self.has_friction:
                values[own] = np.median([fit.inverse_friction.value for fit in fits])
            if self.drifts:
                travels = [deepest / max(float(fit.pose[2]), 0.1 * deepest) * fit.state[LATERAL] for fit in fits]
                values[own + 4 : own + 7] = np.median(travels, axis=0)
        values[[self.shared - 4, self.shared - 3, self.shared - 1]] = np.median(off, axis=0)
        return values

    def information(self, prior: Mounting) -> FloatArray:
        """Return the prior information matrix of all parameters."""
        found = np.zeros((self.size, self.size))
        found[: self.shared, : self.shared] = np.linalg.inv(prior.covariance + 1e-18 * np.eye(self.shared))
        spread = np.array(
            [self.slip_sd if self.has_friction else LEAST_SD, *self.robot_sd, *np.maximum(self.drift_sd, LEAST_SD)]
        )
        own = np.arange(self.shared, self.size)
        found[own, own] = np.tile(spread[: self.own] ** -2.0, len(self.presses))
        return found

    @property
    def _mounted(self) -> IntArray:
        """Indices of the parameters of mounting, 1/µ and lateral motion."""
        every = np.arange(self.shared, self.size).reshape(-1, self.own)
        return np.concatenate([np.arange(len(UNIT_PARAMETERS), self.shared), every[:, 0], every[:, 4:].ravel()])

    def covariance(self, found: NormalEquations, information: FloatArray) -> FloatArray:
        """Return the covariance of all parameters.

        Errors of a marker at rest and of the twin are common to all images and do not average out.
        """
        inverse = np.asarray(np.linalg.inv(found.normal + information), float)
        together = inverse @ found.common
        covariance: FloatArray = inverse + np.repeat(self.shared_variance, 2) * together @ together.T
        covariance[np.diag_indices(self.size)] += self.twin_sd**2
        return covariance

    def _estimate(
        self, posterior: UnitPosterior, found: NormalEquations, information: FloatArray, moved: FloatArray
    ) -> UnitEstimate:
        """Estimate the parameters of the unit by Bayes' rule from the change `moved` (n,) that the fit found.

        With N the curvature of the cost, Λ the prior information and q the true deviation from the prior mean, the
        fit finds

            (N + Λ) d = N q + e,   W = cov(e).

        The error e contains image noise, the errors of rest markers and of the twin that are common to all images,
        and the twin's error in the image scale, which appears as a change of the lens. Hence

            C = (Λ + N W⁻¹ N)⁻¹,   mean = C N W⁻¹ (N + Λ) d.

        Twin error makes no parameter less certain than its prior.
        """
        normal, whole = found.normal, found.normal + information
        off, lens = self.twin_sd, np.zeros(self.size)
        lens[: len(UNIT_PARAMETERS)] = _lens_sd(self.twin.skin)
        common = found.common * np.sqrt(np.repeat(self.shared_variance, 2))
        error = found.gradient_noise + common @ common.T + (whole * off**2) @ whole + (normal * lens**2) @ normal
        # in prior standard deviations; a parameter without information has no error
        scale = np.sqrt(np.diag(np.linalg.inv(information)))
        normal, error = normal * np.outer(scale, scale), error * np.outer(scale, scale)
        told = normal @ np.linalg.inv(error + 1e-9 * np.eye(self.size))
        covariance = np.linalg.inv(information * np.outer(scale, scale) + told @ normal)
        mean = scale * (covariance @ (told @ (scale * (whole @ moved))))
        shared = slice(self.shared)
        before = np.concatenate([posterior.mean.values, np.zeros(len(MOUNTING_PARAMETERS))])
        return UnitEstimate(
            before + mean[shared], np.asarray(covariance * np.outer(scale, scale), float)[shared, shared]
        )

    def predict(
        self, model: UnitModel, mounting: Mounting, pose: FloatArray, own: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Predict pixels (m, 2) of one image of a press, and derivatives (m, 2, 15 + own).

        `own` are the parameters of this press.
        """
        at = mounting.to_dome(pose + own[1:4])
        share = float(at[2] / self.twin.depths_mm[-1])
        looked = model.predict(at, float(own[0]), share * own[4:7] if self.drifts else None)
        assert looked.unit_jacobian is not None
        turn = np.eye(3)
        turn[:2, :2] = mounting.turn.T
        by_robot = looked.pose_jacobian[TILT_SPACE.names] @ turn
        parts = (
            looked.unit_jacobian,
            -by_robot @ mounting.jacobian(at),
            looked.pose_jacobian[("inverse_friction",)] * self.has_friction,
            by_robot,
            share * looked.pose_jacobian[LATERAL if self.drifts else ()],
        )
        return looked.pixels, np.concatenate(parts, axis=-1)

    def assemble(self, model: UnitModel, mounting: Mounting, values: FloatArray) -> NormalEquations:
        """Assemble the normal equations of all images."""
        normal, noise = np.zeros((2, self.size, self.size))
        gradient = np.zeros(self.size)
        common = np.zeros((self.size, 2 * len(model.visible)))
        squares, count = 0.0, 0
        for k, press in enumerate(self.presses):
            own = self.shared + self.own * k
            columns = [*range(self.shared), *range(own, own + self.own)]
            for pose, seen in zip(press.poses, press.pixels, strict=True):
                there = np.isfinite(seen).all(axis=1) & model.visible
                pixels, slopes = self.predict(model, mounting, pose, values[own : own + self.own])
                left = (seen - pixels)[there].reshape(-1)
                jacobian = slopes[there].reshape(len(left), -1)
                variance = self.variance[there]
                weight = robust_weights(left, variance)
                weighted = jacobian * weight[:, None]
                normal[np.ix_(columns, columns)] += weighted.T @ jacobian
                noise[np.ix_(columns, columns)] += (weighted.T * np.repeat(self.noise[there], 2) ** 2) @ weighted
                gradient[columns] += weighted.T @ left
                common[np.ix_(columns, np.flatnonzero(np.repeat(there, 2)))] += weighted.T
                squares, count = squares + float(left @ (left / np.repeat(variance, 2))), count + len(left)
        return NormalEquations(normal, gradient, noise, common, squares / max(count, 1))


class ContradictionError(PalpateError):
    """Calibration presses that no unit of the design, modelled by its twin, can have made."""


def _refuse(unit: FloatArray, misfit: float, deviations: FloatArray) -> None:
    """Raise if misfit, robot error (p, 3) or unit parameter (11,), in standard deviations, is too large."""
    if misfit > _WRONG:
        raise ContradictionError(
            f"The calibration presses do not fit this design: the marker residual is {np.sqrt(misfit):.1f} times "
            "its expected value (limit: 3).",
            "Check design, recording, and the order of the poses.",
            code="calibration-press-misfit",
        )
    worst = np.unravel_index(np.abs(deviations).argmax(), deviations.shape)
    if abs(deviations[worst]) > _FAR:
        raise ContradictionError(
            f"The robot pose of press {worst[0] + 1} deviates from the fit by {abs(deviations[worst]):.0f} "
            "standard deviations (limit: 5).",
            "Check the poses and their order, or increase the robot's uncertainty.",
            code="press-pose-far-off",
        )
    far = np.abs(unit)
    if far.max() > _FAR:
        raise ContradictionError(
            f"The parameter {UNIT_PARAMETERS[far.argmax()]} of the unit deviates from the design by "
            f"{far.max():.0f} standard deviations (limit: 5).",
            "Check that the presses are of this unit, or widen the tolerance.",
            code="unit-far-off-design",
        )
