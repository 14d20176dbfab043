"""Result of an alignment: its presses, its outcome, and the residual angle of the tool."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from palpate.calibration import PoseFit
from palpate.core import FloatArray
from palpate.sensor.placement import Placement


class AlignmentOutcome(StrEnum):
    """Reason for the end of an alignment."""

    SQUARE = "the interval of the angle lies inside the tolerance"
    NO_WALL = "no wall was found within the search distance"
    UNREADABLE = "images could not be read"
    TOO_SHALLOW = "the force limit or the twin's range is reached before an angle can be measured"
    TOO_MANY = "the angle stayed uncertain, or too large, in all presses"


@dataclass(frozen=True, eq=False)
class Touch:
    """One press of an alignment, at its maximum depth.

    Attributes
    ----------
    base_from_flange
        Flange pose reported by the robot.
    fit
        Pose of the wall in the sensor's frame.
    outside
        Whether the pose is beyond the twin's range; such a press directs a rotation but does not end the alignment.
    travel
        Travel from the start of the press, mm.
    force_upper_n
        Upper limit of the force along the wall normal.
    images
        Number of images taken.
    """

    base_from_flange: Placement
    fit: PoseFit
    outside: bool
    travel: float = 0.0
    force_upper_n: float = math.nan
    images: int = 0

    @property
    def tilt_deg(self) -> FloatArray:
        """(2,) rx and ry of the wall in the sensor's frame."""
        return self.fit.pose[:2]

    @property
    def tilt_covariance(self) -> FloatArray:
        """(2, 2) of the tilt, deg²."""
        return self.fit.covariance[:2, :2]

    @property
    def depth(self) -> float:
        """Depth since first contact, mm."""
        return self.fit.state["depth_mm"]


@dataclass(frozen=True, eq=False)
class Alignment:
    """Result of aligning a tool.

    Attributes
    ----------
    outcome
        Reason for the end.
    touches
        Successful presses in order.
    angles_deg
        Angle between drill and wall normal measured by each press.
    half_widths_deg
        Half-widths of the intervals of these angles.
    turned_deg
        Rotation of the flange after each press.
    residual_deg, residual_half_width_deg
        Expected angle after the last rotation, NaN if unknown, and the half-width of its interval, which includes the
        robot's error of that rotation.
    images
        Number of images taken in all.
    """

    outcome: AlignmentOutcome
    touches: tuple[Touch, ...]
    angles_deg: tuple[float, ...]
    half_widths_deg: tuple[float, ...]
    turned_deg: tuple[float, ...]
    residual_deg: float
    residual_half_width_deg: float
    images: int

    @property
    def square(self) -> bool:
        """Whether the tool is square."""
        return self.outcome is AlignmentOutcome.SQUARE


TOUCH_COLUMNS = (
    "touch",
    "rx_deg",
    "ry_deg",
    "depth_mm",
    "angle_deg",
    "half_width_deg",
    "turned_deg",
    "force_n",
    "force_upper_n",
    "friction",
    "images",
)


def list_touches(alignment: Alignment) -> list[dict[str, Any]]:
    """Return one row per press, by `TOUCH_COLUMNS`; friction is empty for 1/µ = 0 (no slip)."""
    columns = zip(
        alignment.touches, alignment.angles_deg, alignment.half_widths_deg, alignment.turned_deg, strict=True
    )
    return [
        {
            "touch": number,
            "rx_deg": float(touch.tilt_deg[0]),
            "ry_deg": float(touch.tilt_deg[1]),
            "depth_mm": touch.depth,
            "angle_deg": angle,
            "half_width_deg": half,
            "turned_deg": turned,
            "force_n": touch.fit.force.normal_force.value,
            "force_upper_n": touch.force_upper_n,
            "friction": 1.0 / slip if (slip := touch.fit.inverse_friction.value) > 0 else None,
            "images": touch.images,
        }
        for number, (touch, angle, half, turned) in enumerate(columns, start=1)
    ]


def describe_alignment(alignment: Alignment) -> dict[str, Any]:
    """Return outcome and residual angle of an alignment as plain data."""
    known = math.isfinite(alignment.residual_deg)
    return {
        "square": alignment.square,
        "outcome": alignment.outcome.name.lower(),
        "reason": str(alignment.outcome),
        "touches": len(alignment.touches),
        "images": alignment.images,
        "residual_deg": alignment.residual_deg if known else None,
        "residual_half_width_deg": alignment.residual_half_width_deg if known else None,
    }
