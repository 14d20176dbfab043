"""A chart is data first: one panel a marker layout, heights against thicknesses."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.grid.grid import Row, SpecificationGrid, depth_text


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


@dataclass(frozen=True, eq=False)
class DepthPanel:
    """RMSE of the angle against the depth of the wall, of all domes with the same markers.

    Attributes
    ----------
    title
        Number of markers, e.g. ``"169 markers"``.
    domes_mm
        (d, 2) height and thickness of each dome (mm), rising.
    depths_mm
        (n,) depths of the images (mm), rising.
    values_deg
        (d, n) RMSE (degrees); NaN where a dome has none at that depth.
    """

    title: str
    domes_mm: tuple[tuple[float, float], ...]
    depths_mm: tuple[float, ...]
    values_deg: NDArray[np.float64]


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
    for row, (height, thickness), markers, layout in _designs(grid):
        table = values.setdefault((markers, layout), np.full((len(heights), len(thicknesses)), np.nan))
        table[heights.index(height), thicknesses.index(thickness)] = _number(row[column])
    return tuple(
        Panel(_title(markers, layout), tuple(heights), tuple(thicknesses), values[markers, layout])
        for markers, layout in sorted(values)
    )


def cut_depth_panels(grid: SpecificationGrid, suffix: str = "") -> tuple[DepthPanel, ...]:
    """Cut the RMSE by depth into panels by rising number of markers; layouts as in `cut_panels`.

    Parameters
    ----------
    grid
        At least one row.
    suffix
        Empty for clean images, ``"_jitter"`` for jittered ones.
    """
    pattern = re.compile(rf"rmse_at_(\d+)_(\d+)mm{suffix}_deg")
    found = (pattern.fullmatch(name) for name in grid.columns)
    depths = tuple(sorted(float(f"{match[1]}.{match[2]}") for match in found if match))
    curves: dict[tuple[int, int], dict[tuple[float, float], list[float]]] = {}
    for row, dome, markers, layout in _designs(grid):
        curve = [_number(row[f"rmse_at_{depth_text(depth)}mm{suffix}_deg"]) for depth in depths]
        curves.setdefault((markers, layout), {})[dome] = curve
    panels = []
    for (markers, layout), curve_of in sorted(curves.items()):
        domes = tuple(sorted(curve_of))
        values = np.array([curve_of[dome] for dome in domes], dtype=float).reshape(len(domes), len(depths))
        panels.append(DepthPanel(_title(markers, layout), domes, depths, values))
    return tuple(panels)


def _designs(grid: SpecificationGrid) -> Iterator[tuple[Row, tuple[float, float], int, int]]:
    """Each row with its dome (height, thickness), number of markers, and which layout of as many markers it is."""
    seen: Counter[tuple[tuple[float, float], int]] = Counter()
    for row in grid.rows:
        dome, markers = (_number(row["height_mm"]), _number(row["thickness_mm"])), int(_number(row["markers"]))
        yield row, dome, markers, seen[dome, markers]
        seen[dome, markers] += 1


def _title(markers: int, layout: int) -> str:
    return f"{markers} marker{'s' if markers != 1 else ''}" + (f", layout {layout + 1}" if layout else "")


def _number(cell: float | int | str | None) -> float:
    return float("nan") if cell is None else float(cell)
