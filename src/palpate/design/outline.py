"""Outlines of sections: points joined by lines, arcs and smooth curves, independent of the CAD kernel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from palpate.core import FloatArray

Point = tuple[float, float]
"""(x, z) or (x, y) in mm."""


@dataclass(frozen=True)
class Arc:
    """Arc of an outline through one point to its end, both (x, z) or (x, y) mm."""

    through: Point
    end: Point


@dataclass(frozen=True)
class SmoothCurve:
    """Smooth curve of an outline through ordered points, (x, z) or (x, y) mm; it ends at the last."""

    through: tuple[Point, ...]

    @property
    def end(self) -> Point:
        """The last point."""
        return self.through[-1]


Outline = Sequence[Point | Arc | SmoothCurve]
"""A point, then straight lines to points, arcs and curves; a closed outline ends at its first point."""

Plan = Callable[[FloatArray], tuple[FloatArray, ...]]
"""Closed plan about the axis, from above: places (n, 2) at angles (n,) in rad, first derivative.

The curvature may be zero at the ends of a quarter, as for a rectangle with rounded corners.
"""
