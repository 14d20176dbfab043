"""An alignment: the touches of a wall, how it ended, and how square the tool then is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from palpate.core import FloatArray
from palpate.sensor.placement import Placement


class AlignmentOutcome(StrEnum):
    """Why an alignment ended."""

    SQUARE = "the interval of the angle lies inside the tolerance"
    NO_WALL = "no wall was touched within the search"
    UNREADABLE = "images could not be read"
    TOO_SHALLOW = "the force that is allowed, or the twin's range, ends before an angle can be told"
    TOO_MANY = "the angle stayed uncertain, or too large, in all touches"


@dataclass(frozen=True, eq=False)
class Touch:
    """One touch at its deepest.

    Attributes
    ----------
    base_from_flange
        Where the robot said that its flange was.
    tilt_deg
        (2,) rx, ry of the wall in the sensor's frame.
    depth
        Since first touch, mm.
    covariance
        (2, 2) deg² of the tilt.
    force_n, force_upper_n
        Force along the wall's normal, and the greatest that its interval allows.
    inverse_friction
        1/µ.
    images
        Images that were looked at.
    outside
        Whether the pose is beyond what the twin knows: good enough to turn by, not to end with.
    """

    base_from_flange: Placement
    tilt_deg: FloatArray
    depth: float
    covariance: FloatArray
    force_n: float
    force_upper_n: float
    inverse_friction: float
    images: int
    outside: bool


@dataclass(frozen=True, eq=False)
class Alignment:
    """What came of squaring a tool.

    Attributes
    ----------
    outcome
        Why it ended.
    touches
        In order; without one that could not be read.
    angles_deg
        Angle between drill and wall's normal as each touch told it.
    half_widths_deg
        Half-widths of their intervals.
    turned_deg
        By how much the flange was turned after each.
    residual_deg, residual_half_width_deg
        Angle that is left after the last turn, as far as is known, and the half-width of its interval, with the
        robot's own error of that turn.
    images
        Images that were looked at in all.
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
    """A row a touch, by `TOUCH_COLUMNS`; friction is empty where nothing slips."""
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
            "force_n": touch.force_n,
            "force_upper_n": touch.force_upper_n,
            "friction": 1.0 / touch.inverse_friction if touch.inverse_friction > 0 else None,
            "images": touch.images,
        }
        for number, (touch, angle, half, turned) in enumerate(columns, start=1)
    ]


def describe_alignment(alignment: Alignment) -> dict[str, Any]:
    """How an alignment ended, and what is left, as plain data."""
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
