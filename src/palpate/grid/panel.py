"""A chart is data first: one panel a marker layout, heights against thicknesses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.grid.grid import Row, SpecificationGrid, depth_of, tilts_of


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
class CurvePanel:
    """One figure of several domes along depth, tilt or number of markers.

    Attributes
    ----------
    title
        What the domes share, e.g. ``"169 markers"`` or ``"H = 20 mm"``.
    domes_mm
        (d, 2) height and thickness of each dome (mm), rising.
    places
        (n,) depths (mm), middles of intervals of tilt (degrees) or numbers of markers, rising.
    values
        (d, n) figures; NaN where a dome has none at that place.
    """

    title: str
    domes_mm: tuple[tuple[float, float], ...]
    places: tuple[float, ...]
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
    for row, (height, thickness), markers, layout in _designs(grid):
        table = values.setdefault((markers, layout), np.full((len(heights), len(thicknesses)), np.nan))
        table[heights.index(height), thicknesses.index(thickness)] = _number(row[column])
    return tuple(
        Panel(_title(markers, layout), tuple(heights), tuple(thicknesses), values[markers, layout])
        for markers, layout in sorted(values)
    )


def cut_depth_panels(grid: SpecificationGrid, column: str = "rmse_deg") -> tuple[CurvePanel, ...]:
    """Cut one figure by depth (mm) into panels by rising number of markers; layouts as in `cut_panels`.

    Parameters
    ----------
    grid
        At least one row.
    column
        Name of a figure that has columns by depth, as ``rmse_deg`` has ``rmse_at_2_4mm_deg``.
    """
    found = {name: depth_of(name) for name in grid.columns}
    return _cut_curves(grid, {at[1]: name for name, at in found.items() if at and at[0] == column})


def cut_tilt_panels(grid: SpecificationGrid, column: str = "rmse_deg") -> tuple[CurvePanel, ...]:
    """Cut one figure by the middles of the intervals of tilt (degrees); parameters as of `cut_depth_panels`."""
    found = {name: tilts_of(name) for name in grid.columns}
    return _cut_curves(grid, {(at[1] + at[2]) / 2: name for name, at in found.items() if at and at[0] == column})


def cut_marker_panels(grid: SpecificationGrid, column: str = "rmse_deg") -> tuple[CurvePanel, ...]:
    """Cut one column of numbers by the number of markers into panels by rising height.

    Of two layouts with the same number of markers on the same dome the first counts.
    """
    counts = tuple(sorted({int(_number(row["markers"])) for row in grid.rows}))
    curves: dict[float, dict[tuple[float, float], list[float]]] = {}
    for row, dome, markers, layout in _designs(grid):
        if layout == 0:
            curve = curves.setdefault(dome[0], {}).setdefault(dome, [float("nan")] * len(counts))
            curve[counts.index(markers)] = _number(row[column])
    places = tuple(float(count) for count in counts)
    return tuple(_curve_panel(f"H = {height:g} mm", curves[height], places) for height in sorted(curves))


def _cut_curves(grid: SpecificationGrid, columns: dict[float, str]) -> tuple[CurvePanel, ...]:
    """One panel a layout, with the columns by the place where each stands on the axis."""
    places = tuple(sorted(columns))
    curves: dict[tuple[int, int], dict[tuple[float, float], list[float]]] = {}
    for row, dome, markers, layout in _designs(grid):
        curve = [_number(row[columns[place]]) for place in places]
        curves.setdefault((markers, layout), {})[dome] = curve
    return tuple(_curve_panel(_title(*key), curves[key], places) for key in sorted(curves))


def _curve_panel(title: str, curves: dict[tuple[float, float], list[float]], places: tuple[float, ...]) -> CurvePanel:
    domes = tuple(sorted(curves))
    values = np.array([curves[dome] for dome in domes], dtype=float).reshape(len(domes), len(places))
    return CurvePanel(title, domes, places, values)


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
