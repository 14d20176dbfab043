"""A reading: what the sensor says about one image."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from palpate.markers import Sighting


class Flag(StrEnum):
    """Why a reading is not to be trusted like others."""

    UNREADABLE = "the image could not be read"
    FEW_MARKERS = "too few markers were found"
    JUMPED = "the markers jumped"
    OUTSIDE = "the markers moved as in no image of the training"


@dataclass(frozen=True)
class Reading:
    """Pose of the wall from one image.

    Attributes
    ----------
    image
        Number of the image since the rest image.
    rx_deg, ry_deg, depth_mm
        Estimate; NaN where there is none.
    half_width
        Half-widths of the intervals of rx, ry (degrees) and depth (mm); infinite where nothing is promised.
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
    """

    image: int
    rx_deg: float
    ry_deg: float
    depth_mm: float
    half_width: tuple[float, float, float]
    touching: bool
    found: int
    flags: tuple[Flag, ...]
    latency_ms: float
    reason: str = ""
    sighting: Sighting | None = field(default=None, compare=False, repr=False)

    @property
    def tilt_deg(self) -> float:
        """Angle between the wall's normal and the dome's axis."""
        return float((self.rx_deg**2 + self.ry_deg**2) ** 0.5)
