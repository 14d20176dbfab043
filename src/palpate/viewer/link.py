"""Link to a view: all settings of the explorer page, as the query of its address."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from typing import Any
from urllib.parse import urlencode

from palpate.core import PalpateError
from palpate.study import SpecificationGrid, filter_rows, ranking_column


class ColourQuantity(StrEnum):
    """Quantity shown by the colour of the skin."""

    DISPLACEMENT = "displacement"
    STRESS = "stress"
    PRESSURE = "pressure"
    CONTACT = "contact"


@dataclass(frozen=True)
class View:
    """Settings of the explorer page.

    Attributes
    ----------
    result
        Name of the opened result in a folder of results; empty if the result was given itself.
    design, other
        Numbers of the design shown and of the compared one; -1 for none.
    metric, across, up
        Columns of the heat maps and of the two axes of the scatter chart.
    where
        Query that selects designs; empty for all.
    depth, tilt, azimuth
        Pose of the wall: mm, degrees, degrees.
    cut_at
        Distance of the cut from the axis, mm; positive where more than half of the skin is cut away.
    colour
        Quantity shown by the colour.
    cut, markers, trails, wall
        Visible parts: the skin behind the cut only, markers, their trails, the wall.
    """

    result: str = ""
    design: int = 0
    other: int = -1
    metric: str = ""
    across: str = ""
    up: str = ""
    where: str = ""
    depth: float = 0.0
    tilt: float = 0.0
    azimuth: float = 0.0
    cut_at: float = 0.0
    colour: ColourQuantity = ColourQuantity.DISPLACEMENT
    cut: bool = True
    markers: bool = True
    trails: bool = True
    wall: bool = True


def write_link(view: View, usual: View) -> str:
    """Return the query of a view, without the question mark and without the values of the view `usual`."""
    chosen = {
        field.name: _write(getattr(view, field.name))
        for field in fields(View)
        if getattr(view, field.name) != getattr(usual, field.name)
    }
    return urlencode(chosen)


def read_link(query: Mapping[str, str], grid: SpecificationGrid) -> tuple[View, tuple[str, ...]]:
    """Read a view from a query, with a message for each invalid part, which is left out.

    Parameters
    ----------
    query
        Names and values; unknown names are ignored.
    grid
        The grid that is shown, with at least one row.
    """
    view, complaints = first_view(grid), []
    for field in fields(View):
        text = query.get(field.name)
        if text is None:
            continue
        try:
            value = _read(text, getattr(view, field.name))
            _check(field.name, value, grid)
        except (ValueError, PalpateError) as error:
            complaints.append(f"The link's {field.name} was left out: {error}")
        else:
            view = replace(view, **{field.name: value})
    return view, tuple(complaints)


def first_view(grid: SpecificationGrid) -> View:
    """Return the initial view of a grid: the best design, its error over all heights and thicknesses."""
    known = numeric_columns(grid)
    metric = ranking_column(known)
    if metric not in known:
        metric = known[0]
    across = next((name for name in ("force_n", "height_mm") if name in known), known[0])
    pressed = [i for i, row in enumerate(grid.designs) if row.get("press_key") and row.get(metric) is not None]
    best = min(pressed, key=lambda i: float(grid.designs[i][metric] or 0.0), default=0)
    return View(design=best, metric=metric, across=across, up=metric, tilt=0.0)


def numeric_columns(grid: SpecificationGrid) -> list[str]:
    """Columns with numbers and without text, in the grid's order, the main ones first."""
    found = []
    for name in grid.columns:
        cells = [row[name] for row in grid.designs]
        if any(isinstance(cell, int | float) for cell in cells) and not any(isinstance(cell, str) for cell in cells):
            found.append(name)
    return found


def selected_rows(grid: SpecificationGrid, where: str) -> frozenset[int]:
    """Return the numbers of the rows for which a query is true; all for an empty one.

    Raises
    ------
    PalpateError
        If the query is invalid.
    """
    if not where.strip():
        return frozenset(range(len(grid.designs)))
    kept = {id(row) for row in filter_rows(grid.designs, where)}
    return frozenset(i for i, row in enumerate(grid.designs) if id(row) in kept)


def _write(value: Any) -> str:
    if isinstance(value, bool):
        return "1" if value else "0"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _read(text: str, usual: Any) -> Any:
    if isinstance(usual, bool):
        if text not in ("0", "1"):
            raise ValueError(f"'{text[:40]}' is neither 0 nor 1.")
        return text == "1"
    if isinstance(usual, ColourQuantity):
        if text not in list(ColourQuantity):
            raise ValueError(f"'{text[:40]}' is not one of {', '.join(ColourQuantity)}.")
        return ColourQuantity(text)
    if isinstance(usual, int | float):
        try:
            value = type(usual)(text)
        except ValueError:
            raise ValueError(f"'{text[:40]}' is no number.") from None
        if not math.isfinite(value):
            raise ValueError(f"'{text[:40]}' is not finite.")
        return value
    return text


def _check(name: str, value: Any, grid: SpecificationGrid) -> None:
    if name in ("design", "other") and not (0 if name == "design" else -1) <= value < len(grid.designs):
        raise ValueError(f"there is no design {value}.")
    if name in ("metric", "across", "up") and value not in numeric_columns(grid):
        raise ValueError(f"the grid has no column of numbers '{str(value)[:40]}'.")
    if name == "where":
        selected_rows(grid, value)
    if name in ("depth", "tilt") and not 0 <= value <= 100:
        raise ValueError(f"{value:g} is out of reach.")
