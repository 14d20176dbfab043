"""Lens distortion: OpenCV's rational model with thin prism, ROS's ``rational_polynomial``.

On the plane at unit distance, with s = x² + y², N = 1 + k1 s + k2 s² + k3 s³ and D = 1 + k4 s + k5 s² + k6 s³,

    x_d = x N / D + 2 p1 x y + p2 (s + 2 x²) + s1 s + s2 s²
    y_d = y N / D + p1 (s + 2 y²) + 2 p2 x y + s3 s + s4 s²

D. Claus, A. W. Fitzgibbon, A rational function lens distortion model for general cameras, CVPR 2005; J. Weng,
P. Cohen, M. Herniou, Camera calibration with distortion models, IEEE PAMI 14 (1992) 965-980.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, final

import numpy as np
from numpy.polynomial import Polynomial

from palpate.camera.arrays import array_module
from palpate.camera.lens import Lens, fold_of, undistort_by_newton
from palpate.core import FloatArray


@final
@dataclass(frozen=True)
class Rational(Lens):
    """Twelve coefficients of lens distortion, in OpenCV's order.

    Attributes
    ----------
    k1, k2, p1, p2, k3, k4, k5, k6
        Radial (k) and tangential (p) coefficients.
    s1, s2, s3, s4
        Thin-prism coefficients.
    """

    name: ClassVar[str] = "rational"
    model: ClassVar[str] = "rational_polynomial"
    leading: ClassVar[str] = "k1"

    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0
    k5: float = 0.0
    k6: float = 0.0
    s1: float = 0.0
    s2: float = 0.0
    s3: float = 0.0
    s4: float = 0.0

    @cached_property
    def max_radius(self) -> float:
        """Maximum radius on the unit plane up to which the radial part grows, before its pole."""
        over = Polynomial([1.0, self.k1, self.k2, self.k3])
        under = Polynomial([1.0, self.k4, self.k5, self.k6])
        growth = over * under + Polynomial([0.0, 2.0]) * (over.deriv() * under - over * under.deriv())
        return min(fold_of(growth.coef.tolist()), fold_of(under.coef.tolist()))

    def distort(self, points: FloatArray) -> FloatArray:
        x, y = points[..., 0], points[..., 1]
        s = x * x + y * y
        radial = self._radial(s)
        return array_module(points).stack(
            [
                x * radial + 2.0 * self.p1 * x * y + self.p2 * (s + 2.0 * x * x) + s * (self.s1 + s * self.s2),
                y * radial + self.p1 * (s + 2.0 * y * y) + 2.0 * self.p2 * x * y + s * (self.s3 + s * self.s4),
            ],
            axis=-1,
        )

    def undistort(self, points: FloatArray) -> FloatArray:
        """Return ideal points by Newton's iteration."""
        return undistort_by_newton(self, self._slope, points)

    def mirrored(self) -> Rational:
        return replace(self, p2=-self.p2, s1=-self.s1, s2=-self.s2)

    def _radial(self, s: FloatArray) -> FloatArray:
        over = 1.0 + s * (self.k1 + s * (self.k2 + s * self.k3))
        ratio: FloatArray = over / (1.0 + s * (self.k4 + s * (self.k5 + s * self.k6)))
        return ratio

    def _slope(self, points: FloatArray) -> FloatArray:
        """Return the derivative (..., 2, 2) of `distort`."""
        x, y = points[..., 0], points[..., 1]
        s = x * x + y * y
        under = 1.0 + s * (self.k4 + s * (self.k5 + s * self.k6))
        radial = self._radial(s)
        own = self.k1 + s * (2.0 * self.k2 + s * 3.0 * self.k3)
        slope = 2.0 * (own - radial * (self.k4 + s * (2.0 * self.k5 + s * 3.0 * self.k6))) / under
        cross = x * y * slope + 2.0 * (self.p1 * x + self.p2 * y)
        prism_x, prism_y = 2.0 * (self.s1 + 2.0 * s * self.s2), 2.0 * (self.s3 + 2.0 * s * self.s4)
        across = radial + x * x * slope + 2.0 * self.p1 * y + 6.0 * self.p2 * x + prism_x * x
        down = radial + y * y * slope + 6.0 * self.p1 * y + 2.0 * self.p2 * x + prism_y * y
        rows = np.stack([across, cross + prism_x * y], axis=-1), np.stack([cross + prism_y * x, down], axis=-1)
        return np.stack(rows, axis=-2)
