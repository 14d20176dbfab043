"""Outlines of sections: points joined by lines, arcs and smooth curves. Numbers only; the CAD kernel draws them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from palpate.core import FloatArray

Point = tuple[float, float]
"""(x, z) or (x, y) in mm."""


@dataclass(frozen=True)
class Arc:
    """An arc of an outline: through one point to its end, both (x, z) or (x, y) mm."""

    through: Point
    end: Point


@dataclass(frozen=True)
class SmoothCurve:
    """A smooth curve of an outline through points in their order, (x, z) or (x, y) mm; it ends at the last."""

    through: tuple[Point, ...]

    @property
    def end(self) -> Point:
        """The last point."""
        return self.through[-1]


Outline = Sequence[Point | Arc | SmoothCurve]
"""An outline: a point, then straight lines to points, arcs and curves; a closed one is joined to its first point."""

Plan = Callable[[FloatArray], tuple[FloatArray, ...]]
"""A closed plan about the axis, seen from above: places (n, 2) at angles (n,) in rad, and their first derivative.

Its quarters may end without curvature, as those of a rectangle with round corners do.
"""
