"""Twin error of poses: a unit as designed, identified and read from exact markers of other presses.

Presses on another mesh, at tilts and frictions between those of the twin, show the errors by mesh and interpolation,
and their effect on calibration presses. All else is as the twin assumes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from palpate.calibration.calibration_press import CalibrationPress, calibration_pose
from palpate.calibration.fit_pose import PoseFitter
from palpate.calibration.identify import identify
from palpate.calibration.noise import NOISE_PX
from palpate.calibration.unit_model import UnitModel
from palpate.camera import project_markers
from palpate.core import FloatArray
from palpate.design import rotation_vector
from palpate.fea import Branch, Press

_READ_TURN_DEG = 36.0
"""Azimuth between successive readings of presses. By hand."""
_READ_TURNS = 3
"""Number of directions in which each press is read. By hand."""
_NEAR = np.array([0.25, 0.125])
"""Standard deviations of the weight of an image in tilt and depth, as shares of their maxima."""


@dataclass(frozen=True, eq=False)
class ValidationPresses:
    """Validation presses of one friction, half models in one direction.

    Attributes
    ----------
    known
        Presses used for calibration, in turn, each rotated by 144° from the one before.
    read
        Presses that are read afterwards.
    """

    known: Sequence[Press]
    read: Sequence[Press]


@dataclass(frozen=True, eq=False)
class TwinError:
    """Errors of a twin without noise.

    Attributes
    ----------
    poses
        (n, 2) tilts (degrees) and depths (mm) of the images read.
    squares
        (n, 2) mean square error of rx and ry (degrees²), and square error of the depth (mm²), of each.
    """

    poses: FloatArray
    squares: FloatArray

    @property
    def rms(self) -> FloatArray:
        """RMS error (3,) over all images: rx and ry (one value for both, degrees) and depth (mm)."""
        return np.asarray(np.sqrt(self.squares.mean(axis=0)[[0, 0, 1]]))

    def at(self, pose: FloatArray) -> FloatArray:
        """Return the RMS error (3,) near a pose (3,), by Gaussian weights over neighbouring images.

        The error is largest for a tilted wall at shallow depth.
        """
        widths = np.maximum(_NEAR * self.poses.max(axis=0), 1e-9)
        away = (((self.poses - [np.hypot(pose[0], pose[1]), pose[2]]) / widths) ** 2).sum(axis=1)
        weight = np.exp(-0.5 * (away - away.min()))
        return np.asarray(np.sqrt(weight @ self.squares / weight.sum())[[0, 0, 1]])


def measure_twin_error(
    model: UnitModel, checks: Sequence[ValidationPresses], count: int, min_depth: float
) -> TwinError:
    """Measure the pose errors of a nominal unit on presses that its twin does not contain.

    Parameters
    ----------
    model
        Nominal unit after its rest image.
    checks
        Validation presses, one entry for each friction.
    count
        Number of calibration presses; may be 0.
    min_depth
        Minimum depth of the images that count, mm.

    Raises
    ------
    PalpateError
        If the calibration presses contradict the twin.
    """
    poses, errors = (
        np.concatenate(each)
        for each in zip(*(_read_checks(model, one, count, min_depth) for one in checks), strict=True)
    )
    places = np.column_stack([np.hypot(poses[:, 0], poses[:, 1]), poses[:, 2]])
    squares = np.column_stack([np.mean(errors[:, :2] ** 2, axis=1), errors[:, 2] ** 2])
    return TwinError(places, squares)


def _read_checks(
    model: UnitModel, checks: ValidationPresses, count: int, min_depth: float
) -> tuple[FloatArray, FloatArray]:
    """Return poses and errors (n, 3) of the images of presses of one friction."""
    told = [
        simulate_exact_markers(
            model, checks.known[number % len(checks.known)], calibration_pose(number, 0.0)[1], min_depth
        )
        for number in range(count)
    ]
    fitter = PoseFitter(model, NOISE_PX)
    if told:
        unit = identify(model, told, NOISE_PX)
        fitter = PoseFitter(model.with_posterior(unit.posterior), NOISE_PX, unit.mounting)
    poses, errors = [], []
    for number, press in enumerate(press for press in checks.read for _ in range(_READ_TURNS)):
        seen = simulate_exact_markers(model, press, _READ_TURN_DEG * number)
        found = np.array([fitter.fit(pixels).pose for pixels in seen.pixels])
        counts = seen.poses[:, 2] >= _least(seen.poses[:, 2], min_depth)
        poses.append(seen.poses[counts])
        errors.append((found - seen.poses)[counts])
    return np.concatenate(poses), np.concatenate(errors)


def simulate_exact_markers(
    model: UnitModel, press: Press, azimuth_deg: float, min_depth: float = 0.0
) -> CalibrationPress:
    """Return poses and exact markers of the loaded increments on the flat branch, for another azimuth."""
    turned = replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": azimuth_deg}))
    azimuth = np.radians(turned.obstacle.turn_deg)
    here = (press.depth > 0.0) & (press.branch == Branch.FLAT)
    here &= press.depth >= _least(press.depth[here], min_depth)
    tilt = rotation_vector(press.obstacle.radial, azimuth)
    poses = np.column_stack([np.tile(tilt, (int(here.sum()), 1)), press.depth[here]])
    edges = turned.positions(model.outlines.places)[here].reshape(int(here.sum()), len(model.visible), -1, 3)
    pixels = np.array([project_markers(model.camera, each).centres for each in edges])
    return CalibrationPress(poses, np.where(model.visible[:, None], pixels, np.nan))


def _least(depths: FloatArray, min_depth: float) -> float:
    """Return the minimum depth (mm) of images that count: at most half the maximum depth."""
    return min(min_depth, 0.5 * float(depths.max(initial=0.0)))
