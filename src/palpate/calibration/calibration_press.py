"""Presses whose pose a robot says, and how well it knows it."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.core import FloatArray

CALIBRATION_TILTS = (0.35, 0.8)
"""Tilts of calibration presses in turn, as shares of the maximum tilt."""
_CALIBRATION_TURN_DEG = 144.0
"""Azimuth from one calibration press to the next, degrees: two fifths of a turn."""


def calibration_pose(number: int, max_tilt_deg: float) -> tuple[float, float]:
    """Tilt and azimuth (degrees) of calibration press 0, 1, …; the azimuth of the first is 0."""
    return CALIBRATION_TILTS[number % len(CALIBRATION_TILTS)] * max_tilt_deg, _CALIBRATION_TURN_DEG * number


@dataclass(frozen=True)
class RobotUncertainty:
    """How well a robot knows its poses: standard deviations of a press in tilt (degrees) and depth (mm).

    `force` is that of a reading of its load cell, N.
    """

    tilt_deg: float = 0.02
    depth: float = 0.02
    force: float = 0.005


@dataclass(frozen=True, eq=False)
class CalibrationPress:
    """One press whose pose the robot says.

    Attributes
    ----------
    poses
        (n, 3) rx, ry (degrees) and depth (mm) on the robot's scale, one an image.
    pixels
        (n, m, 2) px, the layout's dots; NaN where none was seen.
    """

    poses: FloatArray
    pixels: FloatArray
