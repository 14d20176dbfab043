"""Mounting of a unit on its robot: small tilt and rotation, and offset of the depth zero.

With pose p in the skin's frame, the pose on the robot's scale is

    (rx, ry) = R(seating_turn) (p_x, p_y) + (seating_x, seating_y),    depth = p_depth + depth_zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.unit_model import LEAST_SD, UNIT_PARAMETERS, UnitPosterior
from palpate.core import FloatArray
from palpate.core.state import State

SEATING_TILT = ("seating_x_deg", "seating_y_deg")
MOUNTING_PARAMETERS = (*SEATING_TILT, "seating_turn_deg", "depth_zero")
"""Fields of `palpate.calibration.Deviation` that describe the mounting."""


@dataclass(frozen=True, eq=False)
class Mounting:
    """Mounting of a unit on its robot, with the joint covariance of unit and mounting.

    Attributes
    ----------
    mean
        `MOUNTING_PARAMETERS`.
    covariance
        (15, 15) of `UNIT_PARAMETERS` and `MOUNTING_PARAMETERS` together.
    """

    mean: State
    covariance: FloatArray

    @property
    def turn(self) -> FloatArray:
        """Rotation (2, 2) of a tilt from the skin's frame to the robot's."""
        return _turn(self.mean["seating_turn_deg"])

    def to_dome(self, pose: FloatArray) -> FloatArray:
        """Convert a pose (3,) on the robot's scale to the skin's frame."""
        tilt = self.turn.T @ (pose[:2] - self.mean[SEATING_TILT])
        return np.array([*tilt, pose[2] - self.mean["depth_zero"]])

    def to_robot(self, pose: FloatArray, correction: FloatArray | None = None) -> FloatArray:
        """Convert a pose (3,) in the skin's frame to the robot's scale; `correction` (4,) of the mounting."""
        mean = self.mean if correction is None else self.mean.add(MOUNTING_PARAMETERS, correction)
        tilt = _turn(mean["seating_turn_deg"]) @ pose[:2] + mean[SEATING_TILT]
        return np.array([*tilt, pose[2] + mean["depth_zero"]])

    def jacobian(self, pose: FloatArray) -> FloatArray:
        """Return the derivative (3, 4) of the robot's pose by the mounting, at a pose (3,) of the skin."""
        found = np.zeros((3, 4))
        found[0, 0] = found[1, 1] = found[2, 3] = 1.0
        along = self.turn @ pose[:2]
        found[:2, 2] = np.radians(1.0) * np.array([-along[1], along[0]])
        return found


def mounting_prior_sd(tolerance: ToleranceSpec) -> FloatArray:
    """Return the prior standard deviations (4,) of `MOUNTING_PARAMETERS`."""
    sd = np.array([tolerance.seating_tilt_deg] * 2 + [tolerance.seating_turn_deg, tolerance.depth_zero]) / np.sqrt(
        3.0
    )
    return np.maximum(sd, LEAST_SD)


def prior_mounting(posterior: UnitPosterior, tolerance: ToleranceSpec) -> Mounting:
    """Return the mounting before any press: nominal, uniform within the tolerances."""
    covariance = np.zeros((len(UNIT_PARAMETERS) + 4, len(UNIT_PARAMETERS) + 4))
    covariance[: len(UNIT_PARAMETERS), : len(UNIT_PARAMETERS)] = posterior.covariance
    covariance[len(UNIT_PARAMETERS) :, len(UNIT_PARAMETERS) :] = np.diag(mounting_prior_sd(tolerance) ** 2)
    return Mounting(State.zeros(MOUNTING_PARAMETERS), covariance)


def _turn(degrees: float) -> FloatArray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]])
