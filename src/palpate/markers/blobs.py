"""Blobs: the traces of dots in one image."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.core import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Blobs:
    """What was found in one image, from top to bottom.

    Attributes
    ----------
    positions_px
        (n, 2) centres, column and row.
    diameter_px
        (n,) diameter of the disc of equal area.
    contrast
        (n,) difference to the background, in grey levels of the image, positive.
    sigma_px
        (n,) standard deviation of each coordinate that the image's own noise causes; NaN where not known.
    at_border
        (n,) whether the blob is cut by the image's border.
    noise
        Standard deviation of a pixel, grey levels.
    """

    positions_px: FloatArray
    diameter_px: FloatArray
    contrast: FloatArray
    sigma_px: FloatArray
    at_border: BoolArray
    noise: float

    def __len__(self) -> int:
        return len(self.positions_px)
