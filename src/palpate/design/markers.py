"""Marker layout: positions of the markers on the undeformed inner surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray

PRINT_TOLERANCE = 0.2
"""Maximum print error of a marker, mm; our choice, for instructions and inspection."""


@dataclass(frozen=True)
class MarkerLayout:
    """Markers on the undeformed inner surface.

    Attributes
    ----------
    positions
        (n, 3) centres, mm, in the skin's frame: the apex first, then ring by ring from azimuth 0, or in the order of
        the file. z is NaN for a marker outside the skin (`check_design` reports it).
    diameter
        Diameter of a marker, mm.
    """

    positions: FloatArray
    diameter: float

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def on_dome(self) -> BoolArray:
        """Whether each marker (n,) is on the skin."""
        return np.isfinite(self.positions[:, 2])

    def closest_pair(self) -> tuple[int, int, float] | None:
        """Return the indices of the two nearest markers on the skin and their distance, mm; `None` below two."""
        from scipy.spatial import cKDTree

        index = np.flatnonzero(self.on_dome)
        if len(index) < 2:
            return None
        points = self.positions[index]
        distance, near = cKDTree(points).query(points, k=2)
        a = int(np.argmin(distance[:, 1]))
        b = near[a][near[a] != a][0]  # of two in one place, either may come first
        return int(index[a]), int(index[b]), float(distance[a, 1])
