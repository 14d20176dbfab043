"""Tracks: every marker through a sequence of images."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class TrackedMarkers:
    """All markers in one image.

    Attributes
    ----------
    positions_px
        (m, 2) column and row; where no dot was found, the estimate of the motion model.
    found
        (m,) whether a dot was found; the others are estimates.
    blob
        (m,) number of the dot, -1 where none was found.
    jumped
        Whether the markers moved further than the prediction allows: a snap, a lost image or another sensor.
    """

    positions_px: FloatArray
    found: BoolArray
    blob: NDArray[np.intp]
    jumped: bool


@dataclass(frozen=True, eq=False)
class Tracks:
    """Every marker through a sequence of images.

    Attributes
    ----------
    positions_px
        (n, m, 2) column and row of every marker in every image.
    found
        (n, m) whether a dot was found; the others are estimates of the motion model.
    jumped
        (n,) whether the markers jumped (see `TrackedMarkers`).
    """

    positions_px: FloatArray
    found: BoolArray
    jumped: BoolArray

    def __len__(self) -> int:
        return len(self.positions_px)
