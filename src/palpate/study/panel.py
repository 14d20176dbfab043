"""Data of charts: one panel a marker layout, heights by thicknesses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, IntArray
from palpate.study.grid import Row, SpecificationGrid


@dataclass(frozen=True, eq=False)
class Panel:
    """One figure of all skins with the same markers.

    Attributes
    ----------
    title
        Number of markers, e.g. ``"169 markers"``.
    heights_mm, thicknesses_mm
        (h,) and (t,), ascending.
    values
        (h, t) figures; NaN if missing.
    designs
        (h, t) numbers of the designs in the grid; -1 if missing.
    """

    title: str
    heights_mm: tuple[float, ...]
    thicknesses_mm: tuple[float, ...]
    values: FloatArray
    designs: IntArray


@dataclass(frozen=True, eq=False)
class CurvePanel:
    """One figure of several skins by depth, tilt or number of markers.

    Attributes
    ----------
    title
        Common property of the skins, e.g. ``"169 markers"`` or ``"H = 20 mm"``.
    domes_mm
        (d, 2) height and thickness of each skin (mm), ascending.
    places
        (n,) depths (mm), middles of intervals of tilt (degrees) or numbers of markers, ascending.
    values
        (d, n) figures; NaN if missing.
    """

    title: str
    domes_mm: tuple[tuple[float, float], ...]
    places: tuple[float, ...]
    values: FloatArray


def cut_panels(grid: SpecificationGrid, column: str) -> tuple[Panel, ...]:
    """Cut one column of the grid into panels by ascending number of markers.

    Two layouts with the same number of markers on the same skin get a panel each, in the order of the rows.

    Parameters
    ----------
    grid
        At least one design.
    column
        Name of a column of numbers.
    """
    heights = sorted({_number(row["height_mm"]) for row in grid.designs})
    thicknesses = sorted({_number(row["thickness_mm"]) for row in grid.designs})
    shape = (len(heights), len(thicknesses))
    panels: dict[tuple[int, int], Panel] = {}
    for number, (row, (height, thickness), markers, layout) in enumerate(_designs(grid)):
        if (markers, layout) not in panels:
            cells = (np.full(shape, np.nan), np.full(shape, -1))
            panels[markers, layout] = Panel(_title(markers, layout), tuple(heights), tuple(thicknesses), *cells)
        panel = panels[markers, layout]
        place = heights.index(height), thicknesses.index(thickness)
        panel.values[place], panel.designs[place] = _number(row[column]), number
    return tuple(panels[key] for key in sorted(panels))


def cut_depth_panels(grid: SpecificationGrid, column: str = "rmse_deg") -> tuple[CurvePanel, ...]:
    """Cut one figure by depth (mm) into panels by ascending number of markers; layouts as in `cut_panels`.

    Parameters
    ----------
    grid
        At least one design.
    column
        Name of a column of `SpecificationGrid.by_depth`.
    """
    return _cut_curves(grid, [(row, _number(row["depth_mm"])) for row in grid.by_depth], column)


def cut_tilt_panels(grid: SpecificationGrid, column: str = "rmse_deg") -> tuple[CurvePanel, ...]:
    """Cut a column of `by_tilt` by the middles of its intervals (degrees); see `cut_depth_panels`."""
    middles = [(_number(row["tilt_from_deg"]) + _number(row["tilt_to_deg"])) / 2 for row in grid.by_tilt]
    return _cut_curves(grid, list(zip(grid.by_tilt, middles, strict=True)), column)


def cut_marker_panels(grid: SpecificationGrid, column: str = "rmse_deg") -> tuple[CurvePanel, ...]:
    """Cut one column of numbers by the number of markers into panels by ascending height.

    Of two layouts with the same number of markers on the same skin the first counts.
    """
    counts = tuple(sorted({int(_number(row["markers"])) for row in grid.designs}))
    curves: dict[float, dict[tuple[float, float], list[float]]] = {}
    for row, dome, markers, layout in _designs(grid):
        if layout == 0:
            curve = curves.setdefault(dome[0], {}).setdefault(dome, [float("nan")] * len(counts))
            curve[counts.index(markers)] = _number(row[column])
    places = tuple(float(count) for count in counts)
    return tuple(_curve_panel(f"H = {height:g} mm", curves[height], places) for height in sorted(curves))


def _cut_curves(grid: SpecificationGrid, placed: Sequence[tuple[Row, float]], column: str) -> tuple[CurvePanel, ...]:
    """One panel a layout, from rows of a table and the place of each on the axis."""
    figures = {(row["design"], place): _number(row[column]) for row, place in placed if row[column] is not None}
    places = tuple(sorted({place for _, place in figures}))
    curves: dict[tuple[int, int], dict[tuple[float, float], list[float]]] = {}
    for number, (_, dome, markers, layout) in enumerate(_designs(grid)):
        curve = [figures.get((number, place), float("nan")) for place in places]
        curves.setdefault((markers, layout), {})[dome] = curve
    return tuple(_curve_panel(_title(*key), curves[key], places) for key in sorted(curves))


def _curve_panel(title: str, curves: dict[tuple[float, float], list[float]], places: tuple[float, ...]) -> CurvePanel:
    domes = tuple(sorted(curves))
    values = np.array([curves[dome] for dome in domes], dtype=float).reshape(len(domes), len(places))
    return CurvePanel(title, domes, places, values)


def _designs(grid: SpecificationGrid) -> Iterator[tuple[Row, tuple[float, float], int, int]]:
    """Yield each row with its skin (height, thickness), number of markers, and index of its layout."""
    seen: Counter[tuple[tuple[float, float], int]] = Counter()
    for row in grid.designs:
        dome, markers = (_number(row["height_mm"]), _number(row["thickness_mm"])), int(_number(row["markers"]))
        yield row, dome, markers, seen[dome, markers]
        seen[dome, markers] += 1


def _title(markers: int, layout: int) -> str:
    return f"{markers} marker{'s' if markers != 1 else ''}" + (f", layout {layout + 1}" if layout else "")


def _number(cell: float | int | str | None) -> float:
    return float("nan") if cell is None else float(cell)
