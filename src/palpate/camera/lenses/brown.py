"""Lens distortion: the polynomial of Brown (1971), with the coefficients of OpenCV.

On the plane at unit distance, with r² = x² + y²,

    x_d = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
    y_d = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y

The radial part grows only up to the first zero of 1 + 3 k1 r² + 5 k2 r⁴ + 7 k3 r⁶. Beyond it the image folds back and
two directions share a pixel, so no point there can be seen or inverted.

D. C. Brown, Close-range camera calibration, Photogrammetric Engineering 37 (1971) 855-866.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from palpate.camera.arrays import array_module
from palpate.camera.lens import Lens, fold_of, undistort_by_newton
from palpate.core import FloatArray


@final
@dataclass(frozen=True)
class Brown(Lens):
    """Five coefficients of lens distortion.

    Attributes
    ----------
    k1, k2, p1, p2, k3
        Radial (k) and tangential (p) coefficients, in OpenCV's order; all zero for an ideal lens.
    """

    name: ClassVar[str] = "brown"
    model: ClassVar[str] = "plumb_bob"
    leading: ClassVar[str] = "k1"

    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0

    @cached_property
    def max_radius(self) -> float:
        """Maximum radius on the unit plane up to which the radial part grows; infinite for most lenses."""
        return fold_of([1.0, 3.0 * self.k1, 5.0 * self.k2, 7.0 * self.k3])

    def distort(self, points: FloatArray) -> FloatArray:
        if not any(self.coefficients):
            return points
        x, y = points[..., 0], points[..., 1]
        square = x * x + y * y
        radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
        return array_module(points).stack(
            [
                x * radial + 2.0 * self.p1 * x * y + self.p2 * (square + 2.0 * x * x),
                y * radial + self.p1 * (square + 2.0 * y * y) + 2.0 * self.p2 * x * y,
            ],
            axis=-1,
        )

    def undistort(self, points: FloatArray) -> FloatArray:
        """Return ideal points by Newton's iteration."""
        return undistort_by_newton(self, self._slope, points)

    def mirrored(self) -> Brown:
        return replace(self, p2=-self.p2)

    def _slope(self, points: FloatArray) -> FloatArray:
        """Return the derivative (..., 2, 2) of `distort`."""
        x, y = points[..., 0], points[..., 1]
        square = x * x + y * y
        radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
        slope = 2.0 * (self.k1 + square * (2.0 * self.k2 + square * 3.0 * self.k3))
        cross = x * y * slope + 2.0 * (self.p1 * x + self.p2 * y)
        return np.stack(
            [
                np.stack([radial + x * x * slope + 2.0 * self.p1 * y + 6.0 * self.p2 * x, cross], axis=-1),
                np.stack([cross, radial + y * y * slope + 6.0 * self.p1 * y + 2.0 * self.p2 * x], axis=-1),
            ],
            axis=-2,
        )
