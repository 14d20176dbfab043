"""A chart is data first: one panel a marker layout, heights against thicknesses."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.grid.grid import SpecificationGrid


@dataclass(frozen=True, eq=False)
class Panel:
    """One figure of all domes with the same markers.

    Attributes
    ----------
    title
        Number of markers, e.g. ``"169 markers"``.
    heights_mm, thicknesses_mm
        (h,) and (t,), rising.
    values
        (h, t) figures; NaN where there is none.
    """

    title: str
    heights_mm: tuple[float, ...]
    thicknesses_mm: tuple[float, ...]
    values: NDArray[np.float64]


def cut_panels(grid: SpecificationGrid, column: str) -> tuple[Panel, ...]:
    """Cut one column of the grid into panels by rising number of markers.

    Two layouts with the same number of markers on the same dome get a panel each, in the order of the rows.

    Parameters
    ----------
    grid
        At least one row.
    column
        Name of a column of numbers.
    """
    heights = sorted({_number(row["height_mm"]) for row in grid.rows})
    thicknesses = sorted({_number(row["thickness_mm"]) for row in grid.rows})
    values: dict[tuple[int, int], NDArray[np.float64]] = {}
    seen: Counter[tuple[float, float, int]] = Counter()
    for row in grid.rows:
        height, thickness, markers = (
            _number(row["height_mm"]),
            _number(row["thickness_mm"]),
            int(_number(row["markers"])),
        )
        layout = seen[height, thickness, markers]
        seen[height, thickness, markers] += 1
        table = values.setdefault((markers, layout), np.full((len(heights), len(thicknesses)), np.nan))
        table[heights.index(height), thicknesses.index(thickness)] = _number(row[column])
    return tuple(
        Panel(_title(markers, layout), tuple(heights), tuple(thicknesses), values[markers, layout])
        for markers, layout in sorted(values)
    )


def _title(markers: int, layout: int) -> str:
    return f"{markers} marker{'s' if markers != 1 else ''}" + (f", layout {layout + 1}" if layout else "")


def _number(cell: float | int | str | None) -> float:
    return float("nan") if cell is None else float(cell)
