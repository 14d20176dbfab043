"""Principal components of the images: directions in which the markers move more than the jitter.

Clean images of one design lie near a surface of three dimensions (rx, ry, depth) in a space of 2 m pixel
coordinates. Along the principal directions of that surface the signal has variance λ, everywhere the jitter adds
a² / 3. A network that reads

    z = Pᵀ (x − x̄) / sqrt(λ + a²/3)

has inputs of even size and far fewer weights. The map is affine, so it is folded into the first layer afterwards.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray

_AS_GREAT = 1e-6
"""Relative tolerance within which entries of a direction count as equal in magnitude.

It is far above rounding (1e-12) and far below the differences in layouts without symmetry (1e-2).
"""
SMALLEST_SCALE = 1e-6
"""Minimum standard deviation of a component, normalised: for a layout at rest without jitter."""


@dataclass(frozen=True)
class PrincipalComponents:
    """Affine map z = (x − mean) · projection.

    Attributes
    ----------
    mean
        (2m,) normalised coordinates.
    projection
        (2m, k).
    """

    mean: FloatArray
    projection: FloatArray

    def fold(self, weight: FloatArray, bias: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Fold the map into the first layer: weights (r, k, h), bias (r, h) to (r, 2m, h), (r, h)."""
        folded: FloatArray = self.projection @ weight
        return folded, bias - self.mean @ folded


def principal_directions(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Variances (m,), descending, and orthonormal directions (m, m) of a covariance, one a column.

    The entry of largest magnitude of each direction is positive: the sign of an eigenvector depends on the linear
    algebra library, and a changed sign changes the trained network. Of several entries of equal magnitude, as in a
    symmetric layout, the first is taken.
    """
    variance, directions = np.linalg.eigh(covariance)
    sizes = np.abs(directions)
    first = np.argmax(sizes >= (1.0 - _AS_GREAT) * sizes.max(axis=0), axis=0)
    signs = np.where(directions[first, np.arange(len(variance))] < 0, -1.0, 1.0)
    return variance[::-1], (directions * signs)[:, ::-1]


def find_components(
    mean: FloatArray, covariance: FloatArray, count: int, deviation: Callable[[FloatArray], FloatArray]
) -> PrincipalComponents:
    """Find the leading principal components of inputs.

    Parameters
    ----------
    mean, covariance
        (m,) and (m, m) of the inputs.
    count
        Components to keep, at most m.
    deviation
        Scale of each component from its variance: inputs are divided by it.
    """
    variance, directions = principal_directions(covariance)
    scale = np.maximum(deviation(np.maximum(variance[:count], 0.0)), SMALLEST_SCALE)
    return PrincipalComponents(mean, directions[:, :count] / scale)
