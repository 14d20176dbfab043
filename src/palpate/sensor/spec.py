"""Configuration of the readings of a sensor."""

from __future__ import annotations

from palpate.calibration import NOISE_PX
from palpate.core import Spec, parameter


class SensorSpec(Spec):
    """Thresholds of contact, flags and drift tracking, and settings of the rest image."""

    touch_px: float = parameter(
        0.25, unit="px", meaning="RMS displacement of the markers above which the skin is in contact", gt=0, le=20
    )
    min_found: float = parameter(0.6, unit="1", meaning="minimum share of markers found for a pose", gt=0, le=1)
    rest_images: int = parameter(1, unit="1", meaning="number of averaged rest images", ge=1, le=1000)
    refine_lens: bool = parameter(
        False, unit="", meaning="whether focal length and centre of the lens are fitted to the rest image"
    )
    noise_px: float = parameter(
        NOISE_PX, unit="px", meaning="standard deviation of a marker coordinate in one image", gt=0, le=5
    )
    misfit: float = parameter(
        4.0,
        unit="1",
        meaning="mean square residual of a fit over its expected value, above which a reading is flagged",
        gt=1,
    )
    follow_px: float = parameter(
        2.0,
        unit="px",
        meaning="maximum RMS drift of the unloaded markers that is tracked; 0: drift is not tracked",
        ge=0,
        le=20,
    )
    drift_px: float = parameter(
        0.5,
        unit="px",
        meaning="median shift of the markers in the rest image above which an identified unit is rejected",
        gt=0,
        le=50,
    )
