"""How a unit sits on its robot: a little tilted and turned, and touched first where the robot does not believe.

With dome-frame pose p, the robot's is

    (rx, ry) = R(turn) (p_x, p_y) + (tilt_x, tilt_y),    depth = p_depth + touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.unit_model import UNIT_PARAMETERS, UnitPosterior
from palpate.core import FloatArray
from palpate.core.state import State

SEATING_TILT = ("seating_x_deg", "seating_y_deg")
MOUNTING_PARAMETERS = (*SEATING_TILT, "seating_turn_deg", "depth_zero")
"""Numbers of a `palpate.calibration.Deviation` that say how a unit sits on its robot."""


@dataclass(frozen=True, eq=False)
class Mounting:
    """How a unit sits on its robot, beside what is known of the unit.

    Attributes
    ----------
    mean
        `MOUNTING_PARAMETERS`.
    covariance
        (15, 15) of the numbers of `UNIT_PARAMETERS` and of `MOUNTING_PARAMETERS` together.
    """

    mean: State
    covariance: FloatArray

    @property
    def turn(self) -> FloatArray:
        """Rotation (2, 2) of a tilt from the dome's frame to the robot's."""
        return _turn(self.mean["seating_turn_deg"])

    def to_dome(self, pose: FloatArray) -> FloatArray:
        """Pose (3,) in the dome's frame of one on the robot's scale."""
        tilt = self.turn.T @ (pose[:2] - self.mean[SEATING_TILT])
        return np.array([*tilt, pose[2] - self.mean["depth_zero"]])

    def to_robot(self, pose: FloatArray, correction: FloatArray | None = None) -> FloatArray:
        """Pose (3,) on the robot's scale of one in the dome's frame; `correction` (4,) is added to the mounting."""
        mean = self.mean if correction is None else self.mean.add(MOUNTING_PARAMETERS, correction)
        tilt = _turn(mean["seating_turn_deg"]) @ pose[:2] + mean[SEATING_TILT]
        return np.array([*tilt, pose[2] + mean["depth_zero"]])

    def jacobian(self, pose: FloatArray) -> FloatArray:
        """Derivative (3, 4) of the robot's pose by the mounting, at a pose (3,) of the dome's frame."""
        found = np.zeros((3, 4))
        found[0, 0] = found[1, 1] = found[2, 3] = 1.0
        along = self.turn @ pose[:2]
        found[:2, 2] = np.radians(1.0) * np.array([-along[1], along[0]])
        return found


def mounting_prior_sd(tolerance: ToleranceSpec) -> FloatArray:
    """Standard deviations (4,) of `MOUNTING_PARAMETERS` before any press."""
    sd = np.array([tolerance.seating_tilt_deg] * 2 + [tolerance.seating_turn_deg, tolerance.depth_zero]) / np.sqrt(
        3.0
    )
    return np.maximum(sd, 1e-6)


def prior_mounting(posterior: UnitPosterior, tolerance: ToleranceSpec) -> Mounting:
    """How a unit sits on its robot before any press: within the tolerances."""
    covariance = np.zeros((len(UNIT_PARAMETERS) + 4, len(UNIT_PARAMETERS) + 4))
    covariance[: len(UNIT_PARAMETERS), : len(UNIT_PARAMETERS)] = posterior.covariance
    covariance[len(UNIT_PARAMETERS) :, len(UNIT_PARAMETERS) :] = np.diag(mounting_prior_sd(tolerance) ** 2)
    return Mounting(State.zeros(MOUNTING_PARAMETERS), covariance)


def _turn(degrees: float) -> FloatArray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]])
