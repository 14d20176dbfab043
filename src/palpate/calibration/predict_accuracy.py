"""Predicted accuracy of built units of a design, from its twin and the manufacturing tolerances.

The parameters of each unit are drawn from their distribution given the rest image, or given calibration presses as
well. At many poses, the image of such a unit is read by the fit of the twin, linearised about the truth:

    error = [H⁻¹ (Jᵀ R⁻¹ (J_q δq + e + n))]_pose,    H = Jᵀ R⁻¹ J + prior,    J = (J_pose, J_q).

The parameter errors δq and the marker errors e of the rest image are common to all images of a unit; the noise n is
independent in each. Calibration presses attribute part of e to the unit (−T e, see `PredictedPosterior`); this part
cancels in later readings. The posterior of the fit allows for twin error and is wider than the distribution of δq.
Twin error is added to the pose as a whole: measured by validation presses (`measure_twin_error`), or else `twin_sd`,
which was measured on one design. The error of the mounting is added too.

Poses, calibration presses and errors use common random numbers for every layout, camera and skin, so that two designs
differ by their properties and not by sampling.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from palpate.calibration.calibration_press import CalibrationPress, RobotUncertainty, calibration_pose
from palpate.calibration.fit_pose import READ, contact_prior_sd, free_entries, twin_sd
from palpate.calibration.mounting import Mounting, prior_mounting
from palpate.calibration.noise import NOISE_PX, layout_noise
from palpate.calibration.predict_posterior import predict_posterior
from palpate.calibration.scale import model_px
from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.twin_error import ValidationPresses, measure_twin_error
from palpate.calibration.unit_model import UNIT_PARAMETERS, UnitModel, build_unit_model, infer_from_rest
from palpate.camera import Camera
from palpate.core import FloatArray, generator
from palpate.core.state import State
from palpate.design import TILT_SPACE, MarkerLayout, PoseDensity, rotation_vector
from palpate.surrogate import LATERAL, Twin


@dataclass(frozen=True)
class AccuracySpec:
    """Settings of an accuracy prediction.

    Attributes
    ----------
    units, poses
        Sampled units, and poses of each; 2000 units give the 95th percentile a standard error of 1.3 %, 200 of 4 %.
    min_depth, max_tilt_deg
        Working range, mm and degrees.
    noise_px, scale_noise_by_diameter
        Standard deviation of a marker coordinate; with `scale_noise_by_diameter`, that of a marker of `NOISE_DOT_PX`,
        scaled to others by their size in the image (`noise_by_diameter`).
    calibration_presses
        Number of calibration presses of each unit.
    robot
        Uncertainty of the robot's poses in them.
    seed
        Seed of all random numbers.
    """

    units: int = 2000
    poses: int = 60
    min_depth: float = 2.4
    max_tilt_deg: float = 12.0
    noise_px: float = NOISE_PX
    scale_noise_by_diameter: bool = False
    calibration_presses: int = 0
    robot: RobotUncertainty = field(default_factory=RobotUncertainty)
    seed: int = 0


@dataclass(frozen=True)
class PredictedAccuracy:
    """Predicted accuracy of the built units of one design.

    Attributes
    ----------
    calibration_presses
        Number of calibration presses of each unit.
    rmse_deg
        RMSE over rx and ry of all poses of all units.
    p95_deg
        95th percentile over units of each unit's maximum error of rx or ry.
    depth_rmse
        RMSE of the depth without its zero, mm.
    noise_deg
        RMSE by noise alone, with unit and mounting known.
    """

    calibration_presses: int
    rmse_deg: float
    p95_deg: float
    depth_rmse: float
    noise_deg: float


class PoseGain(NamedTuple):
    """Response of a pose estimate (3,) to the standardised parameters (15,) of unit and mounting.

    `marker_gain` (3, 2 n) is the response to an error (px) of each coordinate of the markers visible at rest,
    `image_covariance` (3, 3) the covariance of the independent error of each image, `noise_sd` (3,) the standard
    deviation by noise if all else is known.
    """

    unit_gain: FloatArray
    marker_gain: FloatArray
    image_covariance: FloatArray
    noise_sd: FloatArray


def predict_accuracy(
    twin: Twin,
    layout: MarkerLayout,
    camera: Camera,
    tolerance: ToleranceSpec,
    spec: AccuracySpec | None = None,
    validation_presses: Sequence[ValidationPresses] = (),
) -> PredictedAccuracy:
    """Predict the accuracy of built units of a design.

    Parameters
    ----------
    twin, layout, camera
        The design.
    tolerance
        Tolerances of the units.
    spec
        Working range, noise and calibration presses.
    validation_presses
        Presses on another mesh, between those of the twin, by which the twin error is measured; `twin_sd` without
        any.

    Raises
    ------
    PalpateError
        If the calibration presses among `validation_presses` contradict the twin.
    """
    spec = spec or AccuracySpec()
    rest = camera.project(layout.positions)
    belief = infer_from_rest(twin, layout, camera.spec, rest, tolerance, spec.noise_px)
    noise = marker_noise(twin, layout, camera, spec)
    model = build_unit_model(twin, layout, replace(belief, mean=State.zeros(UNIT_PARAMETERS)), tolerance)
    mounting = prior_mounting(belief, tolerance)
    known = simulate_calibration_presses(model, spec, tolerance, generator(spec.seed, "foresee", "known presses"))
    learnt = predict_posterior(model, mounting, known, noise, spec.robot)
    mounting = replace(mounting, covariance=learnt.covariance)
    spread = np.asarray(np.linalg.cholesky(mounting.covariance + 1e-15 * np.eye(len(mounting.covariance))), float)
    places = sample_working_range(twin, spec, tolerance, generator(spec.seed, "foresee", "poses"))
    gains = [pose_gain(model, mounting, spread, *place, noise) for place in places]
    if validation_presses:
        off = measure_twin_error(model, validation_presses, spec.calibration_presses, spec.min_depth)
        other = [np.diag(off.at(pose) ** 2 - twin_sd(twin.skin)[TILT_SPACE.names] ** 2) for pose, _ in places]
        gains = [
            gain._replace(image_covariance=gain.image_covariance + each)
            for gain, each in zip(gains, other, strict=True)
        ]
    by_chance = np.linalg.cholesky(learnt.exact_twin_covariance + 1e-15 * np.eye(len(spread)))
    unknown, taken = (
        np.linalg.solve(spread, by_chance),
        np.linalg.solve(spread, learnt.rest_marker_gain[:, np.repeat(model.visible, 2)]),
    )
    covariance = _over_images(gains, unknown, taken, np.repeat(noise[model.visible], 2))
    drawn = generator(spec.seed, "foresee", "errors").standard_normal((spec.units, len(covariance)))
    errors = (drawn @ np.linalg.cholesky(covariance).T).reshape(spec.units, -1, 3)
    errors[..., 2] -= np.median(errors[..., 2], axis=1, keepdims=True)
    worst = np.abs(errors[..., :2]).max(axis=(1, 2))
    return PredictedAccuracy(
        calibration_presses=spec.calibration_presses,
        rmse_deg=float(np.sqrt(np.mean(np.diag(covariance).reshape(-1, 3)[:, :2]))),
        p95_deg=float(np.quantile(worst, 0.95)),
        depth_rmse=float(np.sqrt(np.mean(errors[..., 2] ** 2))),
        noise_deg=float(np.sqrt(np.mean([gain.noise_sd[:2] ** 2 for gain in gains]))),
    )


def marker_noise(twin: Twin, layout: MarkerLayout, camera: Camera, spec: AccuracySpec) -> FloatArray:
    """Return the standard deviations (m,) px of a coordinate of every marker of a layout."""
    if spec.scale_noise_by_diameter:
        return layout_noise(twin.skin, layout, camera, spec.noise_px)
    return np.full(len(layout), spec.noise_px)


def _over_images(gains: list[PoseGain], unknown: FloatArray, taken: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the covariance (3 p, 3 p) of the errors of one unit's images, from the responses at p poses.

    `unknown` (15, 15) is a root of the covariance of unit and mounting, and `taken` (15, 2 n) the response of the
    calibration presses to a rest-marker error, both over the standard deviations that the fit assumes. `noise` (2 n,)
    are the standard deviations of the marker coordinates in one image, px.
    """
    by_unit = np.concatenate([gain.unit_gain for gain in gains])
    by_dot = noise * np.concatenate([gain.marker_gain for gain in gains])
    cancelled = by_unit @ (noise * taken) @ by_dot.T
    by_chance = by_unit @ unknown
    found = by_chance @ by_chance.T + by_dot @ by_dot.T - cancelled - cancelled.T
    for k, gain in enumerate(gains):
        found[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += gain.image_covariance
    return np.asarray(found, float)


def sample_working_range(
    twin: Twin, spec: AccuracySpec, tolerance: ToleranceSpec, rng: np.random.Generator
) -> list[tuple[FloatArray, float]]:
    """Sample poses (3,) and 1/µ over the working range, within the range of the twin."""
    found: list[tuple[FloatArray, float]] = []
    most = min(spec.max_tilt_deg, float(twin.tilts_deg[-1]))
    while len(found) < spec.poses:
        tilt, turn = float(PoseDensity.UNIFORM_TILT.radius(rng.uniform(), most)), 2 * np.pi * rng.uniform()
        slip = _draw_inverse_friction(twin, tolerance, rng)
        deepest = twin.max_depth(tilt, slip)
        depth = rng.uniform(min(spec.min_depth, 0.5 * deepest), deepest)
        found.append((np.append(rotation_vector(tilt, turn), depth), slip))
    return found


def _draw_inverse_friction(twin: Twin, tolerance: ToleranceSpec, rng: np.random.Generator) -> float:
    """Sample 1/µ of a wall."""
    slip = 1.0 / tolerance.friction_at(rng.uniform()) if tolerance.friction_min else float(twin.inverse_frictions[0])
    return float(np.clip(slip, twin.inverse_frictions[0], twin.inverse_frictions[-1]))


def simulate_calibration_presses(
    model: UnitModel, spec: AccuracySpec, tolerance: ToleranceSpec, rng: np.random.Generator
) -> list[tuple[CalibrationPress, float]]:
    """Simulate calibration presses of the nominal design, with their 1/µ: two tilts in turn, 144° apart."""
    twin, found = model.marker_twin.twin, []
    first, slip = 2 * np.pi * rng.uniform(), _draw_inverse_friction(twin, tolerance, rng)
    for number in range(spec.calibration_presses):
        tilt, turn_deg = calibration_pose(number, spec.max_tilt_deg)
        depths = np.linspace(spec.min_depth, twin.max_depth(tilt, slip), 8)
        poses = np.array([[*rotation_vector(tilt, first + np.radians(turn_deg)), depth] for depth in depths])
        pixels = np.array([model.predict(pose, slip, unit=False).pixels for pose in poses])
        found.append((CalibrationPress(poses, pixels), slip))
    return found


def pose_gain(
    model: UnitModel,
    mounting: Mounting,
    spread: FloatArray,
    pose: FloatArray,
    inverse_friction: float,
    noise: float | FloatArray,
) -> PoseGain:
    """Compute the linear response of a pose estimate to unit, marker and image errors.

    The unit parameters are marginalised. `noise` is the standard deviation of a marker coordinate, px, or (m,) each.
    """
    sd, seen = contact_prior_sd(model.tolerance), model.visible
    which = free_entries(sd, model.marker_twin.twin)
    looked = model.predict(pose, inverse_friction, np.zeros(3) if set(which) & set(LATERAL) else None)
    assert looked.unit_jacobian is not None
    free = len(which)
    by_pose = looked.pose_jacobian[which][seen].reshape(-1, free)
    by_unit = looked.unit_jacobian[seen].reshape(-1, len(UNIT_PARAMETERS)) @ spread[: len(UNIT_PARAMETERS)]
    own = np.repeat(np.broadcast_to(noise, len(seen))[seen], 2)
    variance = 2.0 * own**2 + model_px(model.marker_twin.twin.skin, model.posterior.nominal) ** 2
    weighted = np.hstack([by_pose, by_unit]) / variance[:, None]
    jacobian = np.hstack([by_pose, by_unit])
    prior = np.concatenate([sd[which] ** -2.0, np.ones(spread.shape[1])])
    gain = np.linalg.solve(weighted.T @ jacobian + np.diag(prior), weighted.T)
    # the unit parameters are fitted too, and change the estimated mounting
    to_robot = np.hstack(
        [np.eye(3), np.zeros((3, free - 3)), mounting.jacobian(pose) @ spread[len(UNIT_PARAMETERS) :]]
    )
    by_noise = to_robot @ gain
    known = np.linalg.inv(weighted[:, :free].T @ by_pose + np.diag(prior[:free]))
    truth = mounting.jacobian(pose) @ spread[len(UNIT_PARAMETERS) :]
    alone = np.sqrt(np.diag(known)[:3] * np.mean(2.0 * own**2 / variance))
    nuisance = [column for column, name in enumerate(which) if name not in READ]  # motion and curvature of the wall
    drift = by_noise @ by_pose[:, nuisance] * sd[tuple(which[column] for column in nuisance)]
    of_image = (
        own**2 * by_noise @ by_noise.T
        + drift @ drift.T
        + np.diag(twin_sd(model.marker_twin.twin.skin)[TILT_SPACE.names] ** 2)
    )
    return PoseGain(by_noise @ by_unit - truth, by_noise, of_image, alone)
