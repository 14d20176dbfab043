"""Normalisation of images for networks: jitter in pixels, then a scale to −1 … 1 or 0 … 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from palpate.core import FloatArray


@dataclass(frozen=True)
class Normalisation:
    """Affine map of pixel coordinates, the same for every marker.

    Attributes
    ----------
    offset_px, scale_px
        (u, v) of the pixel that becomes 0, and pixels that become 1.
    """

    offset_px: tuple[float, float]
    scale_px: tuple[float, float]

    @classmethod
    def of_image(cls, kind: Literal["centred", "unit"], width_px: int, height_px: int) -> Self:
        """Map an image of this size (px) to −1 … 1 about its centre, or to 0 … 1 from its corner."""
        if kind == "centred":
            return cls((width_px / 2, height_px / 2), (width_px / 2, height_px / 2))
        return cls((0.0, 0.0), (float(width_px), float(height_px)))

    def apply(self, images_px: FloatArray) -> FloatArray:
        """Normalise pixels (..., 2)."""
        normalised: FloatArray = (images_px - np.array(self.offset_px)) / np.array(self.scale_px)
        return normalised


def draw_jitter(images_px: FloatArray, jitter_px: float, rng: np.random.Generator) -> FloatArray:
    """Images (..., 2) with every coordinate moved by an independent uniform draw from ±`jitter_px`.

    Examples
    --------
    >>> moved = draw_jitter(np.zeros((2, 3, 2)), 0.5, np.random.default_rng(0))
    >>> moved.shape, bool(np.abs(moved).max() <= 0.5)
    ((2, 3, 2), True)
    """
    return images_px + rng.uniform(-jitter_px, jitter_px, images_px.shape)
