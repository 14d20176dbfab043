"""Superellipse: the plan of a pad, from an ellipse to a rectangle with rounded corners.

Its half axes are 1 along x and k along y, its exponent is n. The *pseudo-radius* of a point

    R(x, y) = (|x|ⁿ + |y/k|ⁿ)^(1/n)

is 1 on the plan and increases in proportion along every ray. The extent of the plan in a direction m is the dual norm
of m (Rockafellar, *Convex Analysis*, 1970, §15),

    h(m) = (|m_x|^q + |k m_y|^q)^(1/q),      1/n + 1/q = 1

For n above 2 the plan has no curvature at the axes: it is flat there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from palpate.core import FloatArray


@final
@dataclass(frozen=True)
class Superellipse:
    """Superellipse with the half axes 1 along x and k = `stretch` ≥ 1 along y, and n = `exponent` ≥ 2."""

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
        """Maximum distance of the plan from its centre, which is also the maximum of h for unit vectors.

        By Hölder's inequality ``(1 + kᵖ)^(1/p)`` with ``p = 2n/(n - 2)``; k for an ellipse.
        """
        if self.exponent == 2.0:
            return self.stretch
        power = 2.0 * self.exponent / (self.exponent - 2.0)
        return float(self.stretch * (1.0 + self.stretch**-power) ** (1.0 / power))

    def pseudo_radius(self, places: FloatArray) -> FloatArray:
        """Return R (...) of places (..., 2), in their unit."""
        return _norm(places / self._axes, self.exponent)

    def level(self, places: FloatArray) -> FloatArray:
        """Map places (n, 2) along y and along their rays so that their distance from the centre is their R."""
        flat = places / self._axes
        length = np.linalg.norm(flat, axis=-1)
        share = np.divide(self.pseudo_radius(places), length, out=np.zeros_like(length), where=length > 0)
        return np.asarray(share[..., None] * flat)

    def gradient(self, places: FloatArray) -> FloatArray:
        """Return the gradient (n, 2) of R at places (n, 2); zero at the centre."""
        flat = places / self._axes
        radius = np.maximum(_norm(flat, self.exponent), np.finfo(float).tiny)[:, None]
        share = np.abs(flat / radius) ** (self.exponent - 1.0)
        return np.asarray(np.sign(flat) * share / self._axes)

    def edge(self, angle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return points (n, 2) of the plan at angles (n,) in rad of the unit disc, and two derivatives.

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
        """Return h (...) of directions (..., 2)."""
        return _norm(np.asarray(ways, float) * self._axes, self._dual)

    def support_point(self, way: FloatArray) -> FloatArray:
        """Return the extreme point (2,) of the plan in a direction (2,); the centre for a zero vector."""
        reach = np.asarray(way, float) * self._axes
        length = float(_norm(reach, self._dual))
        if length == 0.0:
            return np.zeros(2)
        return np.asarray(self._axes * np.sign(reach) * (np.abs(reach) / length) ** (self._dual - 1.0))

    @property
    def _dual(self) -> float:
        return self.exponent / (self.exponent - 1.0)


def _norm(places: FloatArray, exponent: float) -> FloatArray:
    """Return the norm (...) of vectors (..., 2) without underflow of powers."""
    most = np.abs(places).max(axis=-1)
    share = np.abs(places) / np.where(most > 0, most, 1.0)[..., None]
    return np.asarray(most * (share**exponent).sum(axis=-1) ** (1.0 / exponent))
