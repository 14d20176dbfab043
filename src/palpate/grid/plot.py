"""Pictures of any metric of a grid, by kind."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from palpate.core import PalpateError, atomic_write_into
from palpate.grid.grid import SpecificationGrid, column_unit
from palpate.grid.panel import (
    CurvePanel,
    cut_depth_panels,
    cut_marker_panels,
    cut_panels,
    cut_tilt_panels,
)
from palpate.grid.query import check_column

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLOT_KINDS = ("heat", "travel", "depth", "tilt", "markers")
TITLES = {
    "built_rmse_deg": "RMSE of the contact angle, units as built",
    "built_p95_deg": "Greatest error of the contact angle that 19 of 20 units stay below",
    "calibrated_rmse_deg": "RMSE of the contact angle, units told by known presses",
    "calibrated_p95_deg": "Greatest error that 19 of 20 units told by known presses stay below",
    "rmse_deg": "RMSE of the contact angle, clean images",
    "max_error_deg": "Greatest error of the contact angle, clean images",
    "rmse_jitter_deg": "RMSE of the contact angle, jittered images",
    "max_error_jitter_deg": "Greatest error of the contact angle, jittered images",
    "rmse_spread_deg": "Spread of the RMSE over the repeats, clean images",
    "bound_deg": "Least-squares limit of the contact angle, jittered images",
    "bound_pitman_deg": "Pitman limit of the contact angle, jittered images",
    "bound_floor_deg": "Floor of the error of the contact angle, jittered images",
    "rmse_over_bound": "RMSE over the least-squares limit, jittered images",
    "travel_mm": "Marker travel from rest at the greatest depth",
    "peak_stress_straight_mpa": "Greatest von Mises stress, straight press",
    "displacement_mean_straight_mm": "Mean displacement of the dome, straight press",
    "bistable_from_mm": "Depth from which a second state exists",
}
LABELS = {"travel_mm": "mean marker travel (mm)"}
_CURVES: dict[str, tuple[Callable[[SpecificationGrid, str], tuple[CurvePanel, ...]], str]] = {
    "depth": (cut_depth_panels, "depth of the wall (mm)"),
    "tilt": (cut_tilt_panels, "tilt of the wall (deg)"),
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
        What is drawn.
    kind
        ``"heat"``: heights against thicknesses, as the paper's Fig. 12; ``"travel"``: against thickness, as its
        Fig. 11; ``"depth"``, ``"tilt"``, ``"markers"``: curves against these.
    metric
        Name of a column of numbers; for depth and tilt one that is known by depth or by tilt.
    directory
        Made if it does not exist.

    Returns
    -------
    tuple[Path, ...]
        The files.

    Raises
    ------
    PalpateError
        If there is no such kind or metric, no design has the figure, or the folder cannot be written.
    """
    from palpate.grid.draw import write_picture

    check_plot_request(grid, kind, metric)
    name = plot_file_name(kind, metric)
    figure = draw_plot(grid, kind, metric)
    with atomic_write_into(directory, "Choose another with -o.") as drafts:
        write_picture(drafts / name, figure)
        names = sorted(made.name for made in drafts.iterdir())
    return tuple(directory / name for name in names)


def default_metric(grid: SpecificationGrid) -> str:
    """What a person sees first: errors of units as built where they were foreseen, else those of clean images."""
    names = ("built_rmse_deg", "rmse_deg", "rmse_mm")
    return next((name for name in names if name in grid.columns), "rmse_deg")


def draw_grid(grid: SpecificationGrid, metric: str | None = None, kind: str = "heat") -> Figure:
    """Draw one metric of a grid, as `plot_grid` does with its errors, without writing it."""
    metric = metric or default_metric(grid)
    check_plot_request(grid, kind, metric)
    return draw_plot(grid, kind, metric)


def draw_plot(grid: SpecificationGrid, kind: str, metric: str) -> Figure:
    """Draw one metric of a grid; for `kind` and `metric` see `plot_grid`, the grid has at least one row."""
    from palpate.grid.draw import draw_curves, draw_heat_maps, draw_travel

    unit = column_unit(metric)
    angle = f"{metric.removesuffix('_mm')}_deg"
    title = TITLES.get(metric) or TITLES.get(angle, _words(metric)).replace("contact angle", "offset")
    label = LABELS.get(metric, f"{_words(metric)} ({unit})" if unit else _words(metric))
    if kind == "heat":
        return draw_heat_maps(cut_panels(grid, metric), title, unit)
    if kind == "travel":
        return draw_travel(cut_panels(grid, metric), title, label)
    cut, across = _CURVES[kind]
    return draw_curves(cut(grid, metric), f"{title}, by {across.rsplit(' (', 1)[0]}", across, label)


def plot_file_name(kind: str, metric: str) -> str:
    """Name of a picture's file without its ending."""
    short = metric.removesuffix("_deg")
    return _NAMES.get((kind, metric), f"heat_map_{short}" if kind == "heat" else f"{short}_by_{_BY[kind]}")


_BY = {"travel": "thickness", "depth": "depth", "tilt": "tilt", "markers": "markers"}


def check_plot_request(grid: SpecificationGrid, kind: str, metric: str) -> None:
    """Refuse what `plot_grid` cannot draw, with its errors."""
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


def _words(metric: str) -> str:
    unit = column_unit(metric)
    short = metric.removesuffix(f"_{unit.lower()}") if unit else metric
    return short.replace("_", " ").replace("rmse", "RMSE")
