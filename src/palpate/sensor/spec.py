"""What a person may choose about a sensor at work."""

from __future__ import annotations

from palpate.calibration import NOISE_PX
from palpate.core import Spec, parameter


class SensorSpec(Spec):
    """When a reading counts as a touch, and when it is flagged."""

    touch_px: float = parameter(
        0.25, unit="px", meaning="root mean square motion of the markers above which the dome is touched", gt=0, le=20
    )
    min_found: float = parameter(
        0.6, unit="1", meaning="share of the markers that must be found for a pose", gt=0, le=1
    )
    rest_images: int = parameter(1, unit="1", meaning="images at rest that are averaged", ge=1, le=1000)
    refine_lens: bool = parameter(
        False, unit="", meaning="whether the rest image refines focal length and centre of the lens"
    )
    noise_px: float = parameter(
        NOISE_PX, unit="px", meaning="standard deviation of a dot's coordinate in one image", gt=0, le=5
    )
    misfit: float = parameter(
        4.0,
        unit="1",
        meaning="mean square of what a fit leaves over its expectation, above which it is flagged",
        gt=1,
    )
    follow_px: float = parameter(
        2.0,
        unit="px",
        meaning="how far the untouched dots are followed where camera or silicone creep (root mean square)",
        ge=0,
        le=20,
    )
    drift_px: float = parameter(
        0.5,
        unit="px",
        meaning="median shift of the untouched dots above which an identified unit is refused",
        gt=0,
        le=50,
    )
