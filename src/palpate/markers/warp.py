"""A smooth map from the pattern's plane to the image, and how far from it a dot may lie."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray

_POWERS = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
_FEW = 6
"""Dots more than unknowns from which on the residuals tell the spread."""


@dataclass(frozen=True, eq=False)
class Warp:
    """Polynomial in the pattern's plane, fitted by least squares.

    Attributes
    ----------
    middle, size
        Origin (2,) and unit of the polynomial's variables, px of the pattern.
    weights
        (k, 2) factors of the terms, px of the image.
    inverse
        (k, k) inverse of the normal equations.
    spread_px
        Standard deviation of a coordinate of a dot about the map; infinite where too few dots tell it.
    """

    middle: FloatArray
    size: float
    weights: FloatArray
    inverse: FloatArray
    spread_px: float

    def __call__(self, points: FloatArray) -> FloatArray:
        """Pixels (n, 2) of points (n, 2) of the pattern."""
        moved: FloatArray = self._terms(points) @ self.weights
        return moved

    def deviation_px(self, points: FloatArray) -> FloatArray:
        """(n,) standard deviation of a coordinate of one more dot at points (n, 2) of the pattern.

        It is s √(1 + aᵀ (AᵀA)⁻¹ a) with a the terms there: beyond the outermost dots the map itself is less sure.
        """
        terms = self._terms(points)
        return np.asarray(self.spread_px * np.sqrt(1.0 + np.einsum("ni,ij,nj->n", terms, self.inverse, terms)))

    def _terms(self, points: FloatArray) -> FloatArray:
        return _terms((points - self.middle) / self.size, len(self.weights))


def fit_warp(points: FloatArray, pixels: FloatArray, terms: int, whole: FloatArray) -> Warp:
    """Fit the map.

    Parameters
    ----------
    points, pixels
        (n, 2) dots in the pattern's plane and in the image, px.
    terms
        Terms of the polynomial: 3 affine, 6 of second order, 10 of third.
    whole
        (m, 2) all points of the pattern, which give origin and unit.
    """
    middle, size = whole.mean(axis=0), float(np.ptp(whole, axis=0).max()) / 2.0
    design = _terms((points - middle) / size, terms)
    inverse = np.asarray(np.linalg.pinv(design.T @ design), float)
    weights = np.asarray(inverse @ (design.T @ pixels), float)
    free = len(points) - terms
    left = pixels - design @ weights
    # a false dot taken for a marker must not widen what is believed: the median forgives it
    spread = 1.4826 * float(np.median(np.abs(left))) * np.sqrt(len(points) / free) if free >= _FEW else np.inf
    return Warp(middle, size, weights, inverse, spread)


def _terms(points: FloatArray, count: int) -> FloatArray:
    x, y = points[:, 0], points[:, 1]
    return np.stack([np.ones(len(points)), *(x**a * y**b for a, b in _POWERS[: count - 1])], axis=-1)
