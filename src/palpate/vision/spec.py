"""Configuration of the detection of markers in an image."""

from __future__ import annotations

from typing import Literal

from palpate.core import Spec, parameter


class DetectSpec(Spec):
    """Settings of the detection; polarity, size and mask are estimated from the first image unless given."""

    method: Literal["centroid", "opencv"] = parameter(
        "centroid", unit="", meaning="adaptive threshold with fitted centres (centroid), or OpenCV's blob detector"
    )
    polarity: Literal["auto", "dark", "bright"] = parameter(
        "auto", unit="", meaning="whether markers are darker or brighter than the background"
    )
    diameter_px: float | None = parameter(
        None, unit="px", meaning="diameter of a marker; by default estimated from the image", ge=2, le=200
    )
    mask: Literal["auto", "none"] = parameter(
        "auto",
        unit="",
        meaning="restrict the detection to the region of the markers in the first image (auto), or not (none)",
    )
    threshold: float = parameter(
        6.0, unit="1", meaning="minimum contrast of a marker over the noise of the smoothed image", gt=1, le=100
    )
    evenness: float = parameter(
        0.35,
        unit="1",
        meaning="minimum contrast and diameter of a marker over those of the median marker",
        gt=0,
        lt=1,
    )
    roundness: float = parameter(0.4, unit="1", meaning="minimum axis ratio of a marker", gt=0, lt=1)
    largest_mpx: float = parameter(
        40.0, unit="1", meaning="maximum size of an image, in millions of pixels", gt=0, le=1000
    )
