"""Rings of a layout, and the description of a ring by harmonics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray

_SAME = 1e-4
"""Tolerance of radii (over the layout's size) and azimuth steps of a ring. By hand."""
_LEAST_DOTS = 4
"""Minimum number of markers of a ring. By hand."""


@dataclass(frozen=True, eq=False)
class Rings:
    """Rings of evenly spaced markers around an axis, from the inside outwards.

    Attributes
    ----------
    number
        (m,) the ring of each marker: 0 for the one on the axis, then 1, 2, … outwards.
    azimuth
        (m,) its azimuth about the axis.
    rho
        (k + 1,) distance of each ring from the axis, mm.
    height
        (k + 1,) its height along the axis, mm; NaN for a centre without a marker.
    """

    number: NDArray[np.intp]
    azimuth: FloatArray
    rho: FloatArray
    height: FloatArray

    def __len__(self) -> int:
        return len(self.rho) - 1

    def members(self, ring: int) -> NDArray[np.intp]:
        """Return the indices of the markers of a ring."""
        return np.flatnonzero(self.number == ring)


def find_rings(positions: FloatArray) -> Rings | None:
    """Find the rings of a layout (m, 3) mm; `None` unless all markers are on the axis or on rings."""
    x, y = positions[:, 0], positions[:, 1]
    rho, azimuth = np.hypot(x, y), np.arctan2(y, x) % (2.0 * np.pi)
    if not np.isfinite(rho).all() or len(rho) < _LEAST_DOTS or rho.max() == 0.0:
        return None
    order = np.argsort(rho, kind="stable")
    step = np.diff(rho[order]) > _SAME * rho.max()
    number = np.empty(len(rho), int)
    number[order] = np.concatenate([[0], np.cumsum(step)])
    if rho.min() > _SAME * rho.max():
        number += 1
    members = [number == k for k in range(number.max() + 1)]
    radii, heights = (
        np.array([values[each].mean() if each.any() else empty for each in members])
        for values, empty in ((rho, 0.0), (positions[:, 2], np.nan))
    )
    rings = Rings(number, azimuth, radii, heights)
    even = all(_even(azimuth[rings.members(k)]) for k in range(1, len(rings) + 1))
    return rings if even and len(rings) and (number == 0).sum() <= 1 else None


def _even(azimuth: FloatArray) -> bool:
    steps = np.diff(np.sort(azimuth), append=azimuth.min() + 2.0 * np.pi)
    return len(azimuth) >= _LEAST_DOTS and bool(np.ptp(steps) < _SAME)


def ring_harmonics(azimuth: FloatArray, terms: int) -> FloatArray:
    """Return the harmonics (n, terms) 1, cos φ, sin φ, and for five or seven terms those of 2φ and 3φ.

    Coefficients (3, 2) describe an ellipse of any centre on which the markers keep their order; the higher harmonics
    describe perspective and distortion.
    """
    waves_of = [wave(k * azimuth) for k in range(1, terms // 2 + 1) for wave in (np.cos, np.sin)]
    return np.stack([np.ones_like(azimuth), *waves_of], axis=-1)
