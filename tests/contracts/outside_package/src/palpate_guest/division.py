"""The division model of a lens, ``ideal = seen / (1 + k seen²)``.

A. W. Fitzgibbon, Simultaneous linear estimation of multiple view geometry and lens distortion, CVPR 2001.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Lens
from palpate.core import PalpateError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Division(Lens):
    """One coefficient; negative for a barrel."""

    name: ClassVar[str] = "division"
    refinable: ClassVar[Mapping[str, float]] = {"k": 0.1}

    k: float = 0.0

    @property
    def max_radius(self) -> float:
        return float(0.5 / np.sqrt(self.k)) if self.k > 0 else float("inf")

    def distort(self, points: Array) -> Array:
        square = np.sum(points**2, axis=-1, keepdims=True)
        return np.asarray(points * 2 / (1 + np.sqrt(np.maximum(1 - 4 * self.k * square, 0))))

    def undistort(self, points: Array) -> Array:
        square = np.sum(np.asarray(points) ** 2, axis=-1, keepdims=True)
        if np.any(1 + self.k * square <= 0) or np.any(self.k * square > 1):
            raise PalpateError(
                "The lens shows nothing there.", "Use points nearer the middle of the image.", code="lens-folds"
            )
        return np.asarray(points / (1 + self.k * square))

    def mirrored(self) -> Division:
        return self
