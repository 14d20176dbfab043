"""What a person may choose about finding dots in an image."""

from __future__ import annotations

from typing import Literal

from palpate.core import Spec, parameter


class DetectSpec(Spec):
    """How dots are found. Polarity, size and mask are read from the first image unless they are given."""

    method: Literal["centroid", "opencv"] = parameter(
        "centroid", unit="", meaning="adaptive threshold with fitted centres, or OpenCV's blob detector"
    )
    polarity: Literal["auto", "dark", "bright"] = parameter(
        "auto", unit="", meaning="whether dots are darker or brighter than what is about them"
    )
    diameter_px: float | None = parameter(
        None, unit="px", meaning="diameter of a dot; without it, read from the image", ge=2, le=200
    )
    mask: Literal["auto", "none"] = parameter(
        "auto", unit="", meaning="whether dots are looked for only where the first image has a field of them"
    )
    threshold: float = parameter(
        6.0, unit="1", meaning="least contrast of a dot over the noise of the smoothed image", gt=1, le=100
    )
    evenness: float = parameter(
        0.35, unit="1", meaning="least contrast and diameter of a dot over those of the median dot", gt=0, lt=1
    )
    roundness: float = parameter(0.4, unit="1", meaning="least ratio of a dot's axes", gt=0, lt=1)
    largest_mpx: float = parameter(
        40.0, unit="1", meaning="largest image that is looked at, in millions of pixels", gt=0, le=1000
    )
