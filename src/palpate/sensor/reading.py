"""A reading: what the sensor says about one image."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

from palpate.calibration import Force, PoseFit
from palpate.design import TILT_SPACE, PoseSpace
from palpate.sensor.rest_drift import RestDrift
from palpate.vision import TrackedMarkers


class Flag(StrEnum):
    """Why a reading is not to be trusted like others."""

    UNREADABLE = "the image could not be read"
    FEW_MARKERS = "too few markers were found"
    JUMPED = "the markers jumped"
    OUT_OF_DISTRIBUTION = "the markers moved as in no image of the training"
    CAMERA_MOVED = "the camera has moved since the images at rest"
    MISFIT = "no press of this unit looks like the image"
    IMAGE_ONLY = "the dots could not be numbered; the pose is read from the picture"


@dataclass(frozen=True)
class Reading:
    """Pose of the obstacle from one image; ``reading["rx_deg"]`` is one number of it.

    Attributes
    ----------
    image
        Number of the image since the rest image.
    pose
        Estimate by the names and units of `space`; NaN where there is none.
    half_width
        Half-widths of their intervals; infinite where nothing is promised.
    touching
        Whether the dome is touched.
    found
        Number of markers with a dot; the others were estimated.
    flags
        What is wrong; empty for a good reading.
    latency_ms
        Time from the image to the pose.
    reason
        What went wrong with an unreadable image.
    sighting
        Where the markers were seen that the pose comes from; `None` without one.
    space
        What the numbers of the pose are: those that the model was trained for.
    force
        On the wall; `None` where what reads tells none.
    fit
        Covariance and friction, where the unit's twin was fitted.
    rest
        How far the untouched dots have drifted, and were followed, since the images at rest; `None` where nothing
        looks.
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
        """Depth since first touch."""
        return self.pose[2] if self.space.is_line else self.pose[-1]

    @property
    def line(self) -> tuple[float, float]:
        """Offset (mm) and angle (degrees) of an obstacle that lies level; NaN of one that does not."""
        offset, angle = self.space.line(self.pose).tolist() if self.space.is_line else (math.nan, math.nan)
        return offset, angle

    @property
    def radial(self) -> float:
        """Length of the first two components: tilt of a wall (degrees), or offset from the axis (mm)."""
        return math.hypot(*self.pose[:2])
