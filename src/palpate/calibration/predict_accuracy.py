"""How good units of a design will be, before any is built: from its twin and the workshop's tolerances.

Every unit's numbers are drawn from what is known of them after the image at rest, or after known presses as well. At
each of many poses the image of such a unit is read by the fit of the twin, in its linear model about the truth

    error = [H⁻¹ (Jᵀ R⁻¹ (J_q δq + e + n))]_pose,    H = Jᵀ R⁻¹ J + prior,    J = (J_pose, J_q),

with the unit's numbers δq and the errors e of its dots in the image at rest, the same in all its images, and noise n
of its own in each. Known presses take e for something of the unit (−T e, see `PredictedPosterior`), so that a part of
it cancels in what is read afterwards. A fit believes less, since its twin may be off; what that makes of poses is no
part of δq, as it is measured whole. How the unit sits on the robot is added, and what the twin itself is off: by
presses that it lacks (`measure_twin_error`), or without them `twin_sd`, from the bench of one design.

Poses and known presses are drawn alike for every layout, camera and skin, and errors from the same random numbers by
their covariance over all images of a unit, so that two designs differ by what they are and not by chance.
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
    """What is foreseen.

    Attributes
    ----------
    units, poses
        Drawn units, and poses of each; 2000 units give the 95th percentile a standard error of 1.3 %, 200 of 4 %.
    min_depth, max_tilt_deg
        Working range, mm and degrees.
    noise_px, scale_noise_by_diameter
        Standard deviation of a dot's coordinate; with `scale_noise_by_diameter`, that of a dot of `NOISE_DOT_PX`, of
        which those of others follow by their size in the image (`noise_by_diameter`).
    calibration_presses
        Known presses of each unit.
    robot
        How well the robot knows its poses in them.
    seed
        Of everything drawn.
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
    """How good units will be.

    Attributes
    ----------
    calibration_presses
        Known presses of each unit.
    rmse_deg
        Over rx and ry of all poses of all units.
    p95_deg
        Greatest error of rx or ry over the poses that 19 of 20 units stay below.
    depth_rmse
        Of the depth less its zero, mm.
    noise_deg
        RMSE with the unit and its mounting known: what noise alone leaves.
    """

    calibration_presses: int
    rmse_deg: float
    p95_deg: float
    depth_rmse: float
    noise_deg: float


class PoseGain(NamedTuple):
    """Error (3,) of a pose by what is unknown (15,) of unit and mounting, each over its standard deviation.

    `marker_gain` (3, 2 n) is the same by an error (px) of each coordinate of the dots seen at rest,
    `image_covariance` the covariance (3, 3) of the error that each image has of its own, `noise_sd` the standard
    deviation (3,) by noise where all else is known.
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
    """Foresee the errors of built units of a design.

    Parameters
    ----------
    twin, layout, camera
        The design.
    tolerance
        How far units may be from it.
    spec
        Working range, and what is known of a unit beforehand.
    validation_presses
        Presses on another mesh, between those of the twin, that tell what it is off; without any, `twin_sd`.

    Raises
    ------
    PalpateError
        If the known presses among `validation_presses` contradict the twin.
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
    """Standard deviations (m,) px of a coordinate of every dot of a layout."""
    if spec.scale_noise_by_diameter:
        return layout_noise(twin.skin, layout, camera, spec.noise_px)
    return np.full(len(layout), spec.noise_px)


def _over_images(gains: list[PoseGain], unknown: FloatArray, taken: FloatArray, noise: FloatArray) -> FloatArray:
    """Covariance (3 p, 3 p) of the errors of one unit's images.

    Parameters
    ----------
    gains
        Of p poses.
    unknown
        (15, 15) a root of the covariance of what is not known of the unit, over the standard deviations believed in.
    taken
        (15, 2 n) what known presses take an error of a dot at rest for, each over its standard deviation.
    noise
        (2 n,) standard deviations of the dots' coordinates in one image, px.
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
    """Poses (3,) and 1/µ over the working range, as far as the twin reaches."""
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
    """1/µ of a wall."""
    slip = 1.0 / tolerance.friction_at(rng.uniform()) if tolerance.friction_min else float(twin.inverse_frictions[0])
    return float(np.clip(slip, twin.inverse_frictions[0], twin.inverse_frictions[-1]))


def simulate_calibration_presses(
    model: UnitModel, spec: AccuracySpec, tolerance: ToleranceSpec, rng: np.random.Generator
) -> list[tuple[CalibrationPress, float]]:
    """Known presses of the design itself, of two tilts and directions two fifths of a turn apart, and their 1/µ."""
    twin, found = model.dots.twin, []
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
    """How an image of a pose is read by a fit that does not know all of its unit.

    `noise` is the standard deviation of a dot's coordinate in px, or (m,) of each.
    """
    sd, seen = contact_prior_sd(model.tolerance), model.visible
    which = free_entries(sd, model.dots.twin)
    looked = model.predict(pose, inverse_friction, np.zeros(3) if set(which) & set(LATERAL) else None)
    assert looked.unit_jacobian is not None
    free = len(which)
    by_pose = looked.pose_jacobian[which][seen].reshape(-1, free)
    by_unit = looked.unit_jacobian[seen].reshape(-1, len(UNIT_PARAMETERS)) @ spread[: len(UNIT_PARAMETERS)]
    own = np.repeat(np.broadcast_to(noise, len(seen))[seen], 2)
    variance = 2.0 * own**2 + model_px(model.dots.twin.skin, model.posterior.nominal) ** 2
    weighted = np.hstack([by_pose, by_unit]) / variance[:, None]
    jacobian = np.hstack([by_pose, by_unit])
    prior = np.concatenate([sd[which] ** -2.0, np.ones(spread.shape[1])])
    gain = np.linalg.solve(weighted.T @ jacobian + np.diag(prior), weighted.T)
    # a unit's numbers are fitted along, and move what the mounting is taken for
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
        + np.diag(twin_sd(model.dots.twin.skin)[TILT_SPACE.names] ** 2)
    )
    return PoseGain(by_noise @ by_unit - truth, by_noise, of_image, alone)
