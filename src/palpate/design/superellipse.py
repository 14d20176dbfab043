"""The plan of a pad: a superellipse, from an ellipse to a rectangle with round corners.

Its half axes are 1 along x and k along y, its exponent is n. The *pseudo-radius* of a point

    R(x, y) = (|x|ⁿ + |y/k|ⁿ)^(1/n)

is 1 on the plan and grows in proportion along every ray. How far the plan reaches along a way m is the dual norm of m
(Rockafellar, *Convex Analysis*, 1970, §15),

    h(m) = (|m_x|^q + |k m_y|^q)^(1/q),      1/n + 1/q = 1

For n above 2 the plan has no curvature where it meets the axes: a line across an axis touches a flat side there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from palpate.core import FloatArray


@final
@dataclass(frozen=True)
class Superellipse:
    """A superellipse with the half axes 1 along x and k along y.

    Attributes
    ----------
    stretch
        k, at least 1.
    exponent
        n, at least 2.
    """

    stretch: float
    exponent: float

    @property
    def is_round(self) -> bool:
        """Whether it is a circle."""
        return self.stretch == 1.0 and self.exponent == 2.0

    @property
    def _axes(self) -> FloatArray:
        return np.array([1.0, self.stretch])

    @property
    def farthest(self) -> float:
        """Greatest distance of the plan from its middle, which is also the greatest h of a unit vector.

        By Hölder's inequality ``(1 + kᵖ)^(1/p)`` with ``p = 2n/(n - 2)``; of an ellipse k.
        """
        if self.exponent == 2.0:
            return self.stretch
        power = 2.0 * self.exponent / (self.exponent - 2.0)
        return float(self.stretch * (1.0 + self.stretch**-power) ** (1.0 / power))

    def pseudo_radius(self, places: FloatArray) -> FloatArray:
        """R (...) of places (..., 2), in their unit."""
        return _norm(places / self._axes, self.exponent)

    def level(self, places: FloatArray) -> FloatArray:
        """Places (n, 2) moved along y and along their rays until their distance from the middle is their R."""
        flat = places / self._axes
        length = np.linalg.norm(flat, axis=-1)
        share = np.divide(self.pseudo_radius(places), length, out=np.zeros_like(length), where=length > 0)
        return np.asarray(share[..., None] * flat)

    def gradient(self, places: FloatArray) -> FloatArray:
        """Derivative (n, 2) of R by the place, at places (n, 2); zero in the middle."""
        flat = places / self._axes
        radius = np.maximum(_norm(flat, self.exponent), np.finfo(float).tiny)[:, None]
        share = np.abs(flat / radius) ** (self.exponent - 1.0)
        return np.asarray(np.sign(flat) * share / self._axes)

    def edge(self, angle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points (n, 2) of the plan at angles (n,) in rad of the disc it is made of, and two derivatives by them.

        With d = (cos φ, sin φ) and q = |d|ₙ they are ``(1, k) d / q``.
        """
        cos, sin, n = np.cos(angle), np.sin(angle), self.exponent
        a, b = np.abs(cos), np.abs(sin)
        whole = a**n + b**n
        first = (b ** (n - 2) - a ** (n - 2)) * cos * sin / whole
        bend = (n - 1) * (a ** (n - 2) * sin**2 + b ** (n - 2) * cos**2) / whole - 1.0 - n * first**2
        ray, turned = np.column_stack([cos, sin]), np.column_stack([-sin, cos])
        scale = self._axes / (whole ** (1.0 / n))[:, None]
        along = first[:, None]
        curved = -2.0 * along * turned + (along**2 - bend[:, None] - 1.0) * ray
        return scale * ray, scale * (turned - along * ray), scale * curved

    def support(self, ways: FloatArray) -> FloatArray:
        """h (...) of ways (..., 2)."""
        return _norm(np.asarray(ways, float) * self._axes, self._dual)

    def support_point(self, way: FloatArray) -> FloatArray:
        """The point (2,) of the plan that lies farthest along a way (2,); the middle where that has no length."""
        reach = np.asarray(way, float) * self._axes
        length = float(_norm(reach, self._dual))
        if length == 0.0:
            return np.zeros(2)
        return np.asarray(self._axes * np.sign(reach) * (np.abs(reach) / length) ** (self._dual - 1.0))

    @property
    def _dual(self) -> float:
        return self.exponent / (self.exponent - 1.0)


def _norm(places: FloatArray, exponent: float) -> FloatArray:
    """Norm (...) of vectors (..., 2), without losing small ones to their powers."""
    most = np.abs(places).max(axis=-1)
    share = np.abs(places) / np.where(most > 0, most, 1.0)[..., None]
    return np.asarray(most * (share**exponent).sum(axis=-1) ** (1.0 / exponent))
