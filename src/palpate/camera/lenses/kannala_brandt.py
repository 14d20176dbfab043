"""Fisheyes: polynomial of Kannala and Brandt in the angle to the axis, with OpenCV's coefficients.

With ``theta = atan r`` of a point at the distance r from the centre of the unit plane,

    theta_d = theta (1 + k1 theta² + k2 theta⁴ + k3 theta⁶ + k4 theta⁸),   (x_d, y_d) = theta_d / r (x, y)

which holds for directions in front of the camera (theta < 90°) and up to the first zero of d theta_d / d theta.

J. Kannala, S. S. Brandt, A generic camera model and calibration method for conventional, wide-angle, and fish-eye
lenses, IEEE Transactions on Pattern Analysis and Machine Intelligence 28 (2006) 1335-1340.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, final

import numpy as np

from palpate.camera.arrays import array_module
from palpate.camera.lens import Lens, fold_of, folded
from palpate.core import FloatArray

_HALVINGS = 60
"""Halvings of the angle: more than the 53 bits of a number."""
_SMALL = 1e-12
"""Normalised radius below which a point lies on the axis."""


@final
@dataclass(frozen=True)
class KannalaBrandt(Lens):
    """Four coefficients of a fisheye.

    Attributes
    ----------
    k1, k2, k3, k4
        In OpenCV's order; all zero for an image whose radius is proportional to the angle.
    """

    name: ClassVar[str] = "kannala-brandt"
    model: ClassVar[str] = "equidistant"
    leading: ClassVar[str] = "k1"

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    k4: float = 0.0

    @cached_property
    def widest(self) -> float:
        """Maximum angle to the axis, radians, up to which the image grows; at most 90°."""
        return min(fold_of([1.0, 3.0 * self.k1, 5.0 * self.k2, 7.0 * self.k3, 9.0 * self.k4]), np.pi / 2)

    @property
    def max_radius(self) -> float:
        return float(np.tan(self.widest)) if self.widest < np.pi / 2 else float("inf")

    def distort(self, points: FloatArray) -> FloatArray:
        module = array_module(points)
        radius = module.linalg.norm(points, axis=-1, keepdims=True)
        bent = self._distort(module.arctan(radius))
        scale: FloatArray = module.where(radius > _SMALL, bent / module.clip(radius, _SMALL, None), 1.0)
        return points * scale

    def undistort(self, points: FloatArray) -> FloatArray:
        """Return ideal points by bisection over the angle, which grows with the image radius."""
        points = np.asarray(points, float)
        bent = np.linalg.norm(points, axis=-1, keepdims=True)
        if not np.all((bent < self._distort(np.float64(self.widest))) | np.isnan(bent)):
            raise folded(self.max_radius)
        low, high = np.zeros_like(bent), np.full_like(bent, self.widest)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            below = self._distort(middle) < bent
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return np.asarray(points * np.where(bent > _SMALL, np.tan(low) / np.maximum(bent, _SMALL), 1.0))

    def mirrored(self) -> KannalaBrandt:
        return self

    def _distort(self, angle: Any) -> Any:
        square = angle * angle
        series = self.k1 + square * (self.k2 + square * (self.k3 + square * self.k4))
        return angle * (1.0 + square * series)
