"""What a twin is off in the pose: a unit as designed, told and read by it from exact dots of presses that it lacks.

Presses on another mesh, between the tilts and frictions of the twin, show how far its own mesh and the way between
its presses lead it astray, with all that known presses make of that. Everything else is as the twin believes.
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
"""Turn from one direction to the next in which a press is read."""
_READ_TURNS = 3
"""Directions in which each press is read."""
_NEAR = np.array([0.25, 0.125])
"""Standard deviations of an image's weight for a pose in tilt and depth, over the greatest of them."""


@dataclass(frozen=True, eq=False)
class ValidationPresses:
    """Presses of one friction that a twin is held against, of half models in one direction.

    Attributes
    ----------
    known
        Those that are known, in turn, each time two fifths of a turn further.
    read
        Those that are read afterwards.
    """

    known: Sequence[Press]
    read: Sequence[Press]


@dataclass(frozen=True, eq=False)
class TwinError:
    """What a twin is off, without any noise.

    Attributes
    ----------
    poses
        (n, 2) tilts (degrees) and depths (mm) of the images that were read.
    squares
        (n, 2) mean square error of rx and ry (degrees²), and square error of the depth (mm²), of each.
    """

    poses: FloatArray
    squares: FloatArray

    @property
    def rms(self) -> FloatArray:
        """Over all images (3,): rx and ry (one figure for both, degrees) and depth (mm)."""
        return np.asarray(np.sqrt(self.squares.mean(axis=0)[[0, 0, 1]]))

    def at(self, pose: FloatArray) -> FloatArray:
        """The same (3,) about a pose (3,), rx, ry (degrees) and depth (mm), by Gaussian weights of images nearby.

        Twins are off most where a wall is tilted and hardly touches.
        """
        widths = np.maximum(_NEAR * self.poses.max(axis=0), 1e-9)
        away = (((self.poses - [np.hypot(pose[0], pose[1]), pose[2]]) / widths) ** 2).sum(axis=1)
        weight = np.exp(-0.5 * (away - away.min()))
        return np.asarray(np.sqrt(weight @ self.squares / weight.sum())[[0, 0, 1]])


def measure_twin_error(
    model: UnitModel, checks: Sequence[ValidationPresses], count: int, min_depth: float
) -> TwinError:
    """Errors of a unit as designed that its twin reads from presses which the twin lacks.

    Parameters
    ----------
    model
        A unit as designed, as its image at rest tells it.
    checks
        The presses, one for each friction.
    count
        How many presses are known beforehand; 0: none is.
    min_depth
        Of the images that count, mm.

    Raises
    ------
    PalpateError
        If the known presses contradict the twin.
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
    """Poses and errors (n, 3) of the images of presses of one friction that are read."""
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
    """Poses and exact dots of a press before it jumps, deeper than at rest, with its wall turned about the axis."""
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
    """Depth in mm from which images count; where a press hardly gets there, its deeper half."""
    return min(min_depth, 0.5 * float(depths.max(initial=0.0)))
