"""Figures of any metric of a grid, by kind."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from palpate.core import PalpateError, atomic_write_into
from palpate.study.grid import SpecificationGrid, own_column, ranking_column
from palpate.study.grid_columns import grid_column
from palpate.study.grid_query import check_column
from palpate.study.panel import (
    CurvePanel,
    cut_depth_panels,
    cut_marker_panels,
    cut_panels,
    cut_tilt_panels,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLOT_KINDS = ("heat", "travel", "depth", "tilt", "markers")
_CURVES: dict[str, tuple[Callable[[SpecificationGrid, str], tuple[CurvePanel, ...]], str]] = {
    "depth": (cut_depth_panels, "depth of the wall (mm)"),
    "tilt": (cut_tilt_panels, "tilt of the wall (°)"),
    "markers": (cut_marker_panels, "number of markers"),
}
_PLACES = ("design", "depth_mm", "tilt_from_deg", "tilt_to_deg")
_NAMES = {
    ("travel", "travel_mm"): "marker_travel",
    ("depth", "rmse_deg"): "error_by_depth",
    ("depth", "rmse_jitter_deg"): "error_by_depth_jitter",
}


def plot_grid(grid: SpecificationGrid, kind: str, metric: str, directory: Path) -> tuple[Path, ...]:
    """Draw one metric of a grid into a folder, as PNG and SVG.

    Parameters
    ----------
    grid
        The grid.
    kind
        ``"heat"``: heights against thicknesses, as the paper's Fig. 12; ``"travel"``: against thickness, as its
        Fig. 11; ``"depth"``, ``"tilt"``, ``"markers"``: curves against these.
    metric
        Name of a column of numbers; for depth and tilt one of `by_depth` or `by_tilt`.
    directory
        Made if it does not exist.

    Returns
    -------
    tuple[Path, ...]
        The files.

    Raises
    ------
    PalpateError
        If kind or metric is unknown, no design has the figure, or the folder cannot be written.
    """
    from palpate.study.draw_grid import write_picture

    metric = own_column(grid.columns, metric)
    check_plot_request(grid, kind, metric)
    name = plot_file_name(kind, metric)
    figure = draw_plot(grid, kind, metric)
    with atomic_write_into(directory, "Choose another with -o.") as drafts:
        write_picture(drafts / name, figure)
        names = sorted(made.name for made in drafts.iterdir())
    return tuple(directory / name for name in names)


def draw_grid(grid: SpecificationGrid, metric: str | None = None, kind: str = "heat") -> Figure:
    """Draw one metric of a grid as `plot_grid` does, with the same errors, without writing it."""
    metric = own_column(grid.columns, metric or ranking_column(grid.columns))
    check_plot_request(grid, kind, metric)
    return draw_plot(grid, kind, metric)


def draw_plot(grid: SpecificationGrid, kind: str, metric: str) -> Figure:
    """Draw one metric of a grid; for `kind` and `metric` see `plot_grid`, the grid has at least one row."""
    from palpate.study.draw_grid import draw_curves, draw_heat_maps, draw_travel

    column = grid_column(metric)
    title = column.meaning or column.title
    if kind == "heat":
        return draw_heat_maps(cut_panels(grid, metric), title, column.measure)
    if kind == "travel":
        return draw_travel(cut_panels(grid, metric), title, column.label)
    cut, across = _CURVES[kind]
    return draw_curves(cut(grid, metric), f"{title}, by {across.rsplit(' (', 1)[0]}", across, column.label)


def plot_file_name(kind: str, metric: str) -> str:
    """Return the name of a figure's file without its ending."""
    short = metric.removesuffix("_deg")
    return _NAMES.get((kind, metric), f"heat_map_{short}" if kind == "heat" else f"{short}_by_{_BY[kind]}")


_BY = {"travel": "thickness", "depth": "depth", "tilt": "tilt", "markers": "markers"}


def check_plot_request(grid: SpecificationGrid, kind: str, metric: str) -> None:
    """Reject a request that `plot_grid` cannot draw, with its errors."""
    if kind not in PLOT_KINDS:
        raise PalpateError(
            f"There is no kind of picture '{kind}'.",
            f"Choose one of {', '.join(PLOT_KINDS)}.",
            code="picture-kind-unknown",
        )
    if not grid.designs:
        raise PalpateError(
            "The grid has no design.", "Give the result folder of a finished study.", code="grid-empty"
        )
    table = {"depth": grid.by_depth, "tilt": grid.by_tilt}.get(kind)
    if table is None:
        check_column(metric, grid.designs[0])
    elif not table or metric not in table[0]:
        known = ", ".join(name for name in (table[0] if table else ()) if name not in _PLACES) or "none"
        raise PalpateError(
            f"The grid has no '{metric}' by {kind}.", f"By {kind} it has: {known}.", code="metric-unknown"
        )
    cells = [row[metric] for row in (grid.designs if table is None else table)]
    if any(isinstance(cell, str) for cell in cells):
        raise PalpateError(
            f"'{metric}' is a text and cannot be drawn.", "Choose a column of numbers.", code="metric-is-text"
        )
    if not any(isinstance(cell, int | float) and np.isfinite(cell) for cell in cells):
        raise PalpateError(f"No design has a figure for '{metric}'.", "Choose another metric.", code="metric-empty")
