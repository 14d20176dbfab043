"""A pattern laid over dots, before it is known which of its symmetric turns is the right one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray


@dataclass(frozen=True, eq=False)
class PatternFit:
    """Which dot is at which place of the pattern.

    Attributes
    ----------
    blob
        (m,) dot at each marker's place, -1 where there is none.
    places_px
        (m, 2) where the print's own law expects each dot.
    residual_px
        Root of the mean squared distance of the dots from there.
    mirrored
        Whether the pattern was laid in its mirror.
    marks_px, mark_axes_px
        (g, 2) where the orientation mark would be under each symmetry, and (g, 2, 2) two axes about it as long as its
        standard deviations along them; `None` without a mark.
    doubt
        What speaks against it, as a part of a sentence; empty where nothing does.
    """

    blob: NDArray[np.intp]
    places_px: FloatArray
    residual_px: float
    mirrored: bool
    marks_px: FloatArray | None
    mark_axes_px: FloatArray | None
    doubt: str = ""

    @property
    def count(self) -> int:
        """Number of markers that have a dot."""
        return int((self.blob >= 0).sum())
