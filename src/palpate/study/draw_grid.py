"""Figures of a grid: heat maps as in the paper's Fig. 12, marker travel as in its Fig. 11, curves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from palpate.study.panel import CurvePanel, Panel

CELL_INCH = 0.85
"""Side of a cell of a heat map."""
PANEL_INCH = 1.9
"""Minimum width of a panel for its title and the name of its axis."""
TITLE_INCH = 3.9
"""Minimum width of a figure for its title."""
DOTS_PER_INCH = 160
"""Resolution of an image."""
COLOURS = "viridis"
FEW = 0.1
"""Limit below which numbers have three decimals."""
MARKS = "osD^vPX*"
LINES = ("-", "--", "-.", ":")


def draw_heat_maps(panels: Sequence[Panel], title: str, unit: str) -> Figure:
    """Draw one heat map a panel with the number in every cell; all share one colour scale.

    Parameters
    ----------
    panels
        At least one.
    title
        Title of the figure.
    unit
        Its unit, for the scale of colours.
    """
    rows, columns = panels[0].values.shape
    width = max(PANEL_INCH, CELL_INCH * columns)
    figure = _empty_figure(width * len(panels) + 1.6, CELL_INCH * rows + 1.4)
    every = np.concatenate([panel.values[np.isfinite(panel.values)] for panel in panels])
    scale = mpl.colors.Normalize(*((every.min(), every.max()) if len(every) else (0.0, 1.0)))
    colours = mpl.colormaps[COLOURS].with_extremes(bad="0.9")
    axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    for axis, panel in zip(axes, panels, strict=True):
        image = axis.imshow(panel.values, norm=scale, cmap=colours, origin="lower", aspect="equal")
        axis.set_title(panel.title, fontsize=10)
        axis.set_xlabel("thickness T (mm)")
        axis.set_xticks(range(columns), [f"{value:g}" for value in panel.thicknesses_mm])
        axis.set_yticks(range(rows), [f"{value:g}" for value in panel.heights_mm])
        axis.tick_params(length=0)
        axis.spines[:].set_visible(False)
        for (row, column), value in np.ndenumerate(panel.values):
            _write_number(axis, (column, row), value, colours(scale(value)))
    axes[0].set_ylabel("height H (mm)")
    figure.colorbar(image, ax=list(axes), label=unit, shrink=0.9)
    figure.suptitle(title.replace(", ", "\n"), fontsize=11)
    return figure


def draw_travel(panels: Sequence[Panel], title: str, label: str = "mean marker travel (mm)") -> Figure:
    """Draw marker travel, or another figure, against thickness, one panel a layout and one line a height.

    Parameters
    ----------
    panels
        At least one.
    title
        Title of the figure.
    label
        Name of the figure with its unit.
    """
    figure = _empty_figure(2.4 * len(panels) + 1.4, 3.2)
    axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    colours = mpl.colormaps[COLOURS](np.linspace(0.0, 0.85, len(panels[0].heights_mm)))
    for axis, panel in zip(axes, panels, strict=True):
        for number, (height, travel) in enumerate(zip(panel.heights_mm, panel.values, strict=True)):
            mark = MARKS[number % len(MARKS)]
            axis.plot(panel.thicknesses_mm, travel, color=colours[number], marker=mark, label=f"H = {height:g} mm")
        axis.set_xlabel("thickness T (mm)")
        axis.set_xticks(panel.thicknesses_mm)
        axis.margins(x=0.15)
    _finish(axes, panels, label)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper", frameon=False)
    figure.suptitle(title.replace(", ", "\n"), fontsize=11)
    return figure


def draw_curves(panels: Sequence[CurvePanel], title: str, across: str, label: str) -> Figure:
    """Draw a figure against depth, tilt or number of markers, one line a dome.

    A colour is a height, a mark and a kind of line a thickness.

    Parameters
    ----------
    panels
        At least one.
    title
        Title of the figure.
    across, label
        Names of the two axes with their units.
    """
    figure = _empty_figure(2.6 * len(panels) + 1.8, 3.6)
    axes = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    domes = sorted({dome for panel in panels for dome in panel.domes_mm})
    heights, thicknesses = (sorted({dome[part] for dome in domes}) for part in (0, 1))
    colours = mpl.colormaps[COLOURS](np.linspace(0.0, 0.85, len(heights)))
    lines: dict[tuple[float, float], Any] = {}
    for axis, panel in zip(axes, panels, strict=True):
        for dome, errors in zip(panel.domes_mm, panel.values, strict=True):
            number = thicknesses.index(dome[1])
            style = {"linestyle": LINES[number % len(LINES)], "marker": MARKS[number % len(MARKS)], "markersize": 4}
            colour = colours[heights.index(dome[0])]
            lines[dome] = axis.plot(panel.places, errors, color=colour, linewidth=1.2, **style)[0]
        axis.set_xlabel(across)
    _finish(axes, panels, label)
    labels = [f"H {height:g}, T {thickness:g} mm" for height, thickness in domes]
    figure.legend([lines[dome] for dome in domes], labels, loc="outside right upper", frameon=False, fontsize=9)
    figure.suptitle(title.replace(", ", "\n"), fontsize=11)
    return figure


def write_picture(path: Path, figure: Figure) -> None:
    """Write a figure as `path` with the endings ``.png`` and ``.svg``, reproducibly."""
    with mpl.rc_context({"svg.hashsalt": "palpate"}):
        figure.savefig(path.with_suffix(".png"), dpi=DOTS_PER_INCH, metadata={"Software": None})
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None, "Creator": None})


def _empty_figure(width: float, height: float) -> Figure:
    return Figure(figsize=(max(width, TITLE_INCH), height), layout="constrained")


def _finish(axes: Sequence[Any], panels: Sequence[Panel | CurvePanel], label: str) -> None:
    for axis, panel in zip(axes, panels, strict=True):
        axis.set_title(panel.title, fontsize=10)
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    greatest = max((float(np.nanmax(p.values)) for p in panels if np.isfinite(p.values).any()), default=1.0)
    axes[0].set_ylim(0.0, 1.1 * greatest)
    axes[0].set_ylabel(label)


def _write_number(axis: Any, place: tuple[int, int], value: float, colour: tuple[float, ...]) -> None:
    luminance = float(np.dot(colour[:3], (0.2126, 0.7152, 0.0722)))
    text = f"{value:.{2 if abs(value) >= FEW else 3}f}" if np.isfinite(value) else "–"
    axis.text(*place, text, ha="center", va="center", fontsize=9, color="black" if luminance > 0.45 else "white")
