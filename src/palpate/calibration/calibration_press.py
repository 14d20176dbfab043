"""Calibration presses: poses given by a robot, and the robot's uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.core import FloatArray

CALIBRATION_TILTS = (0.35, 0.8)
"""Tilts of successive calibration presses, as shares of the maximum tilt. By hand."""
_CALIBRATION_TURN_DEG = 144.0
"""Azimuth between successive calibration presses, degrees: two fifths of a turn. By hand."""


def calibration_pose(number: int, max_tilt_deg: float) -> tuple[float, float]:
    """Return tilt and azimuth (degrees) of calibration press 0, 1, …; the first azimuth is 0."""
    return CALIBRATION_TILTS[number % len(CALIBRATION_TILTS)] * max_tilt_deg, _CALIBRATION_TURN_DEG * number


@dataclass(frozen=True)
class RobotUncertainty:
    """Standard deviations of a robot's pose of a press, in tilt (degrees) and depth (mm).

    `force` is the standard deviation of a load-cell reading, N.
    """

    tilt_deg: float = 0.02
    depth: float = 0.02
    force: float = 0.005


@dataclass(frozen=True, eq=False)
class CalibrationPress:
    """Images of one press at poses (n, 3) on the robot's scale: rx, ry (degrees) and depth (mm).

    `pixels` (n, m, 2) are those of the layout's markers; NaN for a marker that was not detected.
    """

    poses: FloatArray
    pixels: FloatArray
