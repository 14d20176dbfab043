"""The rings of a layout: which marker is on which ring, and how a ring of dots is described."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray

_SAME = 1e-4
"""Difference of radii over the layout's size, and of azimuths, up to which markers share a ring evenly."""
_LEAST_DOTS = 4
"""Fewer dots are not taken for a ring."""


@dataclass(frozen=True, eq=False)
class Rings:
    """Rings of evenly spaced markers about an axis, from the inside outwards.

    Attributes
    ----------
    number
        (m,) the ring of each marker: 0 for the one on the axis, then 1, 2, … outwards.
    azimuth
        (m,) its azimuth about the axis.
    rho
        (k + 1,) distance of each ring from the axis, mm.
    height
        (k + 1,) its height along the axis, mm; NaN for a middle without a marker.
    """

    number: NDArray[np.intp]
    azimuth: FloatArray
    rho: FloatArray
    height: FloatArray

    def __len__(self) -> int:
        return len(self.rho) - 1

    def members(self, ring: int) -> NDArray[np.intp]:
        """Numbers of the markers of a ring."""
        return np.flatnonzero(self.number == ring)


def find_rings(positions: FloatArray) -> Rings | None:
    """The rings of a layout (m, 3) mm; `None` where not all markers are on rings of four or more, or on the axis."""
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
    """(n, terms) 1, cos φ, sin φ, and of five or seven terms cos and sin of 2φ and 3φ: what a bent ring is made of.

    With weights (3, 2) they are an ellipse of any centre on which the dots keep their order; the higher harmonics are
    what perspective and distortion add.
    """
    waves_of = [wave(k * azimuth) for k in range(1, terms // 2 + 1) for wave in (np.cos, np.sin)]
    return np.stack([np.ones_like(azimuth), *waves_of], axis=-1)
