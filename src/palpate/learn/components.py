"""Principal components of the images: what moves, in the few directions in which it moves more than the jitter.

Clean images of one design lie near a surface of three dimensions (rx, ry, depth) in a space of 2 m pixel
coordinates. Along the principal directions of that surface the signal has variance λ, everywhere the jitter adds
a² / 3. A network that reads

    z = Pᵀ (x − x̄) / sqrt(λ + a²/3)

has inputs of even size and far fewer weights. The map is affine, so it is folded into the first layer afterwards.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray

_AS_GREAT = 1e-6
"""Share by which entries of a direction may differ and count as great alike; far above rounding, 1e-12, and far below
what distinguishes them where a layout has no symmetry, 1e-2."""
SMALLEST_SCALE = 1e-6
"""Least standard deviation of a component, in normalised units: guards a layout at rest without jitter."""


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
        """First layer that reads x in place of z: from weights (r, k, h), bias (r, h) to (r, 2m, h), (r, h)."""
        folded: FloatArray = self.projection @ weight
        return folded, bias - self.mean @ folded


def _signed(directions: FloatArray) -> FloatArray:
    """The same directions (m, k), each with the sign that makes its entry of greatest magnitude positive.

    Which sign an eigenvector has is up to the linear algebra library, and a network trained on the other one is
    another network. Of entries as great, as a symmetric layout has them, the first counts.
    """
    sizes = np.abs(directions)
    first = np.argmax(sizes >= (1.0 - _AS_GREAT) * sizes.max(axis=0), axis=0)
    return np.asarray(directions * np.where(directions[first, np.arange(directions.shape[1])] < 0, -1.0, 1.0))


def find_components(inputs: FloatArray, jitter: FloatArray, count: int) -> PrincipalComponents:
    """Find the leading principal components of clean inputs.

    Parameters
    ----------
    inputs
        (n, 2m) normalised clean images.
    jitter
        (2m,) half-width of the uniform jitter, normalised.
    count
        Components to keep; 0 keeps the coordinates themselves, centred.

    Returns
    -------
    Components
        At most `count` components, fewer where the images have fewer coordinates.
    """
    mean = inputs.mean(axis=0)
    if count == 0:
        return PrincipalComponents(np.zeros_like(mean), np.eye(len(mean)))
    covariance = np.cov(inputs, rowvar=False)
    variance, direction = np.linalg.eigh(np.atleast_2d(covariance))
    leading = np.argsort(variance)[::-1][:count]
    direction = _signed(direction)
    noise = float(np.mean(jitter**2)) / 3
    scale = np.sqrt(np.maximum(variance[leading], 0.0) + noise)
    return PrincipalComponents(mean, direction[:, leading] / np.maximum(scale, SMALLEST_SCALE))
