"""Reading: the output of the sensor for one image."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from palpate.calibration import Force, PoseFit
from palpate.design import PoseEstimate, PoseSpace
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Reading(PoseEstimate):
    """Pose of the obstacle from one image; ``reading["rx_deg"]`` returns one component.

    Attributes
    ----------
    touching
        Whether the skin is in contact.
    flags
        Reasons to distrust the reading; empty for a good one.
    found
        Number of markers with a blob; the positions of the remaining markers were estimated.
    image
        Number of the image since the rest image.
    latency_ms
        Time from the image to the pose.
    reason
        Error of an unreadable image.
    sighting
        Marker positions from which the pose was estimated; `None` without a pose.
    force
        Force on the wall; `None` if it is not estimated.
    fit
        Covariance and friction, if the unit's twin was fitted.
    rest
        Tracked drift of the markers since the rest images; `None` if the estimator does not track it.
    """

    touching: bool
    flags: tuple[Flag, ...]
    found: int = 0
    image: int = 0
    latency_ms: float = 0.0
    reason: str = ""
    sighting: TrackedMarkers | None = field(default=None, repr=False)
    force: Force | None = field(default=None, repr=False)
    fit: PoseFit | None = field(default=None, repr=False)
    rest: RestDrift | None = field(default=None, repr=False)

    def __getitem__(self, name: str) -> float:
        return float(self.pose[self.space.names.index(name)])

    @staticmethod
    def without_pose(space: PoseSpace, flag: Flag, found: int = 0, reason: str = "") -> Reading:
        """Return the flagged reading of an image from which no pose was estimated."""
        none, anything = np.full(len(space.names), np.nan), np.full(len(space.names), np.inf)
        return Reading(
            pose=none, half_width=anything, touching=False, flags=(flag,), found=found, reason=reason, space=space
        )

    @property
    def depth_mm(self) -> float:
        """Depth since first contact."""
        return float(self.pose[2] if self.space.is_line else self.pose[-1])

    @property
    def line(self) -> tuple[float, float]:
        """Offset (mm) and angle (degrees) of a line obstacle; NaN for other obstacles."""
        offset, angle = self.space.line(self.pose).tolist() if self.space.is_line else (math.nan, math.nan)
        return offset, angle

    @property
    def radial(self) -> float:
        """Length of the first two components: tilt of a wall (degrees), or offset from the axis (mm)."""
        return math.hypot(*self.pose[:2])
