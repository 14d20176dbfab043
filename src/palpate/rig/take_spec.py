"""Configuration of the acquisition of a recording: its presses and its image check."""

from __future__ import annotations

from typing import Self

import numpy as np
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from palpate.core import FloatArray, Spec, parameter

PlannedPress = tuple[float, float]
"""Tilt and azimuth of a press, degrees."""


class ImageCheckSpec(Spec):
    """Limits of a usable image."""

    blank: float = parameter(
        0.01,
        unit="1",
        meaning="standard deviation of means of 4 × 4 px, as a share of the range, below which an image is blank",
        source="By hand: a covered lens gives the noise of the image sensor, 0.01 or less; rendered images give 0.1",
        ge=0,
        le=1,
    )
    saturated: float = parameter(
        0.5, unit="1", meaning="share of pixels at the maximum above which an image is saturated", ge=0, le=1
    )


class TakeSpec(ImageCheckSpec):
    """Presses, rest images and timing of a recording."""

    tilts: int = parameter(5, unit="1", meaning="number of tilts, at even distances up to the maximum", ge=1, le=100)
    azimuths: int = parameter(12, unit="1", meaning="number of azimuths per tilt", ge=1, le=360)
    depths: int = parameter(4, unit="1", meaning="number of images per press, at even depths", ge=1, le=1000)
    max_tilt_deg: float = parameter(10.0, unit="deg", meaning="maximum tilt", gt=0, le=30)
    min_depth: float = parameter(1.0, unit="mm", meaning="depth of the first image of a press", gt=0, le=60)
    depth: float = parameter(4.0, unit="mm", meaning="depth of the last image of a press", gt=0, le=60)
    next: int = parameter(
        0,
        unit="1",
        meaning="number of presses that each reduce the predicted error of the unit most, in place of tilts and "
        "azimuths; requires a twin",
        ge=0,
        le=100,
    )
    rest_images: int = parameter(5, unit="1", meaning="number of images of the unloaded skin", ge=1, le=100)
    dwell_s: float = parameter(0.5, unit="s", meaning="waiting time before each image", flag="dwell", ge=0, le=600)
    clear: float = parameter(3.0, unit="mm", meaning="distance from the wall at which the flange is rotated", gt=0)
    tool_length: float = parameter(
        0.0, unit="mm", meaning="distance from the flange to the middle of the skin's base", ge=0, le=1000
    )

    buffered: int = parameter(
        5, unit="1", meaning="number of images that a camera buffers, and that are discarded", ge=0, le=1000
    )

    @property
    def depths_mm(self) -> FloatArray:
        """Depths (n,) mm of the images of a press."""
        return self.depth - np.linspace(0.0, self.depth - self.min_depth, self.depths)[::-1]

    @model_validator(mode="after")
    def _depths_ascend(self) -> Self:
        if self.depths > 1 and self.min_depth >= self.depth:
            raise PydanticCustomError(
                "take-depths-fall",
                "min_depth is {first} mm, and depth is {last} mm; give a smaller min_depth.",
                {"first": self.min_depth, "last": self.depth},
            )
        return self

    def grid(self) -> list[PlannedPress]:
        """Presses at all tilts and azimuths; azimuths of every other tilt are half a step ahead."""
        turns = np.degrees(np.linspace(0.0, 2.0 * np.pi, 2 * self.azimuths, endpoint=False))
        tilts = np.linspace(0.0, self.max_tilt_deg, self.tilts + 1)[1:]
        return [(float(tilt), float(turn)) for k, tilt in enumerate(tilts) for turn in turns[k % 2 :: 2]]
