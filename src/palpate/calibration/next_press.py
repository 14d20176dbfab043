"""Choice of the next calibration press: the one with the minimum predicted error of later images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from palpate.calibration.calibration_press import CALIBRATION_TILTS, CalibrationPress
from palpate.calibration.mounting import Mounting
from palpate.calibration.predict_accuracy import AccuracySpec, pose_gain
from palpate.calibration.predict_posterior import predict_posterior
from palpate.calibration.unit_model import UnitModel
from palpate.core import FloatArray
from palpate.design import rotation_vector

_TILTS = (0.0, *CALIBRATION_TILTS)
"""Tilts of the candidates, as shares of the maximum tilt."""
_TURNS_DEG = tuple(range(0, 360, 45))
_IMAGES = 6
"""Number of images of a candidate, at even depths. By hand."""


class NextPress(NamedTuple):
    """Candidate for the next calibration press: (rx, ry) = tilt (cos, sin) of the azimuth.

    `rmse_deg` is the predicted RMSE of rx and ry by the remaining uncertainty of the unit.
    """

    tilt_deg: float
    azimuth_deg: float
    rmse_deg: float


def rank_next_presses(
    model: UnitModel, mounting: Mounting, inverse_friction: float, spec: AccuracySpec
) -> tuple[float, tuple[NextPress, ...]]:
    """Predict the errors now, and after each candidate press, in ascending order.

    `model` and `mounting` are the present ones of the unit, `inverse_friction` is 1/µ of its presses. The errors are
    the RMSE of rx and ry by the uncertainty of the unit, degrees.
    """
    places = _tilted(spec, model, (0.2, 0.6, 1.0), 90)
    now, found = _rmse(model, mounting, inverse_friction, places, spec.noise_px), []
    for share in _TILTS:
        for turn_deg in _TURNS_DEG if share else (0,):
            tilt = share * spec.max_tilt_deg
            poses = _deepening(model, spec, tilt, turn_deg, inverse_friction)
            pixels = np.array([model.predict(pose, inverse_friction, unit=False).pixels for pose in poses])
            known = [(CalibrationPress(poses, pixels), inverse_friction)]
            learnt = predict_posterior(model, mounting, known, spec.noise_px, spec.robot)
            after = replace(mounting, covariance=learnt.covariance)
            found.append(
                NextPress(tilt, float(turn_deg), _rmse(model, after, inverse_friction, places, spec.noise_px))
            )
    return now, tuple(sorted(found, key=lambda press: press.rmse_deg))


def _tilted(spec: AccuracySpec, model: UnitModel, shares: Sequence[float], turn_deg: int) -> list[FloatArray]:
    """Return poses over the working range."""
    deepest = float(model.marker_twin.twin.depths_mm[-1])
    turns = np.radians(np.arange(0, 360, turn_deg))
    return [
        np.append(rotation_vector(spec.max_tilt_deg * share, turn), depth)
        for share in shares
        for turn in turns
        for depth in (spec.min_depth, 0.9 * deepest)
    ]


def _deepening(
    model: UnitModel, spec: AccuracySpec, tilt: float, turn_deg: float, inverse_friction: float
) -> FloatArray:
    turn, twin = np.radians(turn_deg), model.marker_twin.twin
    depths = np.linspace(spec.min_depth, twin.max_depth(tilt, inverse_friction), _IMAGES)
    return np.array([[*rotation_vector(tilt, turn), depth] for depth in depths])


def _rmse(
    model: UnitModel, mounting: Mounting, inverse_friction: float, places: Sequence[FloatArray], noise_px: float
) -> float:
    spread = np.asarray(np.linalg.cholesky(mounting.covariance + 1e-15 * np.eye(len(mounting.covariance))), float)
    squares = [
        (pose_gain(model, mounting, spread, pose, inverse_friction, noise_px).unit_gain[:2] ** 2).sum(axis=1)
        for pose in places
    ]
    return float(np.sqrt(np.mean(squares)))
