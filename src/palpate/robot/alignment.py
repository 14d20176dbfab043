"""An alignment: the touches of a wall, how it ended, and how square the tool then is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from palpate.core import FloatArray
from palpate.robot.placement import Placement


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
