"""Configuration of the check of a camera: number of images, and the limit of each figure."""

from __future__ import annotations

from palpate.core import parameter
from palpate.rig.take_spec import ImageCheckSpec

_RANGE = "Between good image sets and the weakest faults of benchmarks/camera_check.py"


class CameraCheckSpec(ImageCheckSpec):
    """Images and limits of the check of a camera; light is a share of the maximum grey value."""

    rest_images: int = parameter(60, unit="1", meaning="maximum number of images of the unloaded skin", ge=1)
    press_images: int = parameter(60, unit="1", meaning="maximum number of images of presses", ge=1)
    interval_s: float = parameter(
        0.0, unit="s", meaning="time between images of a live camera; 0 tests its rate", flag="interval", ge=0, le=600
    )
    significant: float = parameter(4.0, unit="1", meaning="standard errors at which a drift counts", ge=0)
    unreadable: int = parameter(
        0, unit="1", meaning="maximum number of images without the markers, or unreadable", ge=0
    )
    frozen: float = parameter(0.5, unit="1", meaning="maximum share of images that equal the one before", ge=0)
    saturated: float = parameter(
        0.01,
        unit="1",
        meaning="maximum share of pixels among the markers at the maximum grey value",
        source=_RANGE,
        ge=0,
    )
    dark: float = parameter(
        0.25,
        unit="1",
        meaning="minimum light of skin or markers, the brighter",
        source="Below, two bits are lost",
        ge=0,
    )
    markers: int = parameter(7, unit="1", meaning="minimum number of markers found", ge=0)
    at_border: int = parameter(0, unit="1", meaning="maximum number of markers cut by the image's border", ge=0)
    contrast: float = parameter(
        0.2, unit="1", meaning="minimum contrast of markers over the light", source="Noise is inverse to it", ge=0
    )
    evenness: float = parameter(
        0.45,
        unit="1",
        meaning="minimum light at the 5th percentile of markers over the 95th",
        source="Markers of less than 0.35 of the median contrast are lost (DetectSpec.evenness)",
        ge=0,
    )
    focus: float = parameter(
        0.5,
        unit="1",
        meaning="maximum blur (standard deviation) of a marker's edge over its radius",
        source="At 0.5 the centre of a disc loses exp(-2) = 14 % of its contrast",
        ge=0,
    )
    noise_px: float = parameter(
        0.05,
        unit="px",
        meaning="maximum standard deviation of a marker coordinate between images",
        source="2.5 times that of predicted accuracy (palpate.calibration.noise), and so are errors of angles",
        ge=0,
    )
    motion_blur_px: float = parameter(
        1.5,
        unit="px",
        meaning="maximum motion of markers in an exposure: up to half of it is an error",
        source=_RANGE,
        ge=0,
    )
    vibration_px: float = parameter(
        0.1, unit="px", meaning="maximum standard deviation of the shift between images at rest", source=_RANGE, ge=0
    )
    drift_px: float = parameter(
        0.15,
        unit="px",
        meaning="maximum trend of shift and rotation of all markers at rest, rms",
        source="A sensor reports such a motion as that of its camera (docs/sensor.md)",
        ge=0,
    )
    magnification_px: float = parameter(
        0.1,
        unit="px",
        meaning="maximum change of marker positions by the magnification at rest, rms",
        source=_RANGE,
        ge=0,
    )
    sharpness: float = parameter(
        0.15, unit="1", meaning="maximum relative change of the blur at rest", source=_RANGE, ge=0
    )
    brightness: float = parameter(
        0.03, unit="1", meaning="maximum relative change of the light at rest", source=_RANGE, ge=0
    )
    auto_exposure: float = parameter(
        0.06,
        unit="1",
        meaning="maximum change of the light by a press at 90 % of the markers",
        source=_RANGE,
        ge=0,
    )
    white_balance: float = parameter(
        0.03,
        unit="1",
        meaning="maximum relative change of a colour at 90 % of the markers",
        source=_RANGE,
        ge=0,
    )
    dropped: float = parameter(
        0.01, unit="1", meaning="maximum share of missing images by time stamps", source=_RANGE, ge=0
    )
    irregular: float = parameter(
        0.15,
        unit="1",
        meaning="maximum standard deviation of the intervals between images over their median",
        source=_RANGE,
        ge=0,
    )
