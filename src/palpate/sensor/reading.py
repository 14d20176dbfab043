"""Reading: the output of the sensor for one image."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

from palpate.calibration import Force, PoseFit
from palpate.design import TILT_SPACE, PoseSpace
from palpate.sensor.rest_drift import RestDrift
from palpate.vision import TrackedMarkers


class Flag(StrEnum):
    """Reason to distrust a reading."""

    UNREADABLE = "the image could not be read"
    FEW_MARKERS = "too few markers were found"
    JUMPED = "the markers jumped"
    OUT_OF_DISTRIBUTION = "the markers moved unlike in any training image"
    CAMERA_MOVED = "the camera has moved since the rest images"
    MISFIT = "no press of this unit looks like the image"
    IMAGE_ONLY = "the markers could not be assigned; the pose is estimated from the image"


@dataclass(frozen=True)
class Reading:
    """Pose of the obstacle from one image; ``reading["rx_deg"]`` returns one component.

    Attributes
    ----------
    image
        Number of the image since the rest image.
    pose
        Estimate by the names and units of `space`; NaN without a pose.
    half_width
        Half-widths of the intervals; infinite if unknown.
    touching
        Whether the skin is in contact.
    found
        Number of markers with a blob; the positions of the remaining markers were estimated.
    flags
        Reasons to distrust the reading; empty for a good one.
    latency_ms
        Time from the image to the pose.
    reason
        Error of an unreadable image.
    sighting
        Marker positions from which the pose was estimated; `None` without a pose.
    space
        Components of the pose.
    force
        Force on the wall; `None` if it is not estimated.
    fit
        Covariance and friction, if the unit's twin was fitted.
    rest
        Tracked drift of the markers since the rest images; `None` if the estimator does not track it.
    """

    image: int
    pose: tuple[float, ...]
    half_width: tuple[float, ...]
    touching: bool
    found: int
    flags: tuple[Flag, ...]
    latency_ms: float
    reason: str = ""
    sighting: TrackedMarkers | None = field(default=None, compare=False, repr=False)
    space: PoseSpace = TILT_SPACE
    force: Force | None = field(default=None, compare=False, repr=False)
    fit: PoseFit | None = field(default=None, compare=False, repr=False)
    rest: RestDrift | None = field(default=None, compare=False, repr=False)

    def __getitem__(self, name: str) -> float:
        return self.pose[self.space.names.index(name)]

    @property
    def depth_mm(self) -> float:
        """Depth since first contact."""
        return self.pose[2] if self.space.is_line else self.pose[-1]

    @property
    def line(self) -> tuple[float, float]:
        """Offset (mm) and angle (degrees) of a line obstacle; NaN for other obstacles."""
        offset, angle = self.space.line(self.pose).tolist() if self.space.is_line else (math.nan, math.nan)
        return offset, angle

    @property
    def radial(self) -> float:
        """Length of the first two components: tilt of a wall (degrees), or offset from the axis (mm)."""
        return math.hypot(*self.pose[:2])
