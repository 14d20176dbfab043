"""Charts of the page as data for ECharts."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.study import Cell, Row, SpecificationGrid, cut_panels, design_label, grid_column

VIRIDIS = (
    "#440154",
    "#482475",
    "#414487",
    "#355f8d",
    "#2a788e",
    "#21918c",
    "#22a884",
    "#44bf70",
    "#7ad151",
    "#bddf26",
    "#fde725",
)
"""Eleven steps of the colour map viridis: perceptually uniform and safe for colour-blind users."""
FIRST, SECOND, LIMIT = "#0072b2", "#d55e00", "#999999"
"""Colours of the design shown, of the compared one, and of bounds (Okabe and Ito)."""

_HEAT_PX = 318
"""Minimum width of the heat maps, that of a side column of `style.css`."""

Chart = dict[str, Any]


@dataclass(frozen=True)
class Theme:
    """Colours of text, faint text, lines and ground, as CSS."""

    text: str
    faint: str
    line: str
    ground: str


LIGHT = Theme("#1f2933", "#5c6b7a", "#d5dde5", "#ffffff")
DARK = Theme("#e4e9ee", "#9aa8b5", "#3a4550", "#1b2229")


@dataclass(frozen=True)
class Selection:
    """Highlighted rows: those that match the query, the design shown and the compared one (or -1)."""

    selected: Collection[int]
    design: int
    other: int = -1


@dataclass(frozen=True)
class ChartCurve:
    """One line of a chart: a name, its points, its colour and whether it is dashed."""

    name: str
    points: Sequence[tuple[float, float]]
    colour: str
    dashed: bool = False


def heat_chart(grid: SpecificationGrid, metric: str, chosen: Selection, ink: Theme) -> Chart:
    """Heat maps of a column, one a marker layout, heights over thicknesses; each value ends in its row."""
    panels = cut_panels(grid, metric)
    figures = [float(value) for panel in panels for value in panel.values.flat if math.isfinite(value)]
    low, high = min(figures, default=0.0), max(figures, default=1.0)
    bright = low + 0.55 * (high - low)
    series = [
        {
            "type": "heatmap",
            "name": panel.title,
            "xAxisIndex": i,
            "yAxisIndex": i,
            "data": [
                _heat_cell(int(number), grid.designs[number], ((x, y), metric, bright), chosen, ink)
                for (y, x), number in np.ndenumerate(panel.designs)
                if number >= 0
            ],
        }
        for i, panel in enumerate(panels)
    ]
    axes = ([f"{value:g}" for value in panels[0].thicknesses_mm], [f"{value:g}" for value in panels[0].heights_mm])
    return {
        **_panels([panel.title for panel in panels], axes, ink),
        "series": series,
        "visualMap": {
            "type": "continuous",
            "min": low,
            "max": high if high > low else low + 1.0,
            "dimension": 2,
            "seriesIndex": list(range(len(panels))),
            "inRange": {"color": list(VIRIDIS)},
            "orient": "horizontal",
            "left": "center",
            "bottom": 0,
            "itemWidth": 10,
            "itemHeight": 150,
            "text": [grid_column(metric).text(high), grid_column(metric).text(low)],
            "textStyle": {"color": ink.text, "fontSize": 11},
        },
        "tooltip": {"appendToBody": True},
        "animation": False,
        "aria": {"enabled": True, "label": {"description": f"Heat maps of {grid_column(metric).label} by design."}},
    }


def _heat_cell(
    number: int, row: Row, drawn: tuple[tuple[int, int], str, float], chosen: Selection, ink: Theme
) -> Chart:
    (x, y), metric, bright = drawn
    value = _figure(row[metric])
    kept = number in chosen.selected and value is not None
    border = {chosen.design: FIRST, chosen.other: SECOND}.get(number, ink.ground)
    marked = number in (chosen.design, chosen.other)
    name = design_label(row)
    text = grid_column(metric).text(value)
    short = "–" if value is None else f"{value:#.2g}".rstrip(".") if abs(value) < 99.5 else f"{value:.0f}"
    dark_text = value is not None and value > bright
    return {
        "name": name,
        "value": [x, y, value if value is not None else "-", number],
        "visualMap": kept,
        "itemStyle": {
            **({} if kept else {"color": ink.line}),
            "borderColor": border,
            "borderWidth": 3 if marked else 1,
        },
        "label": {
            "show": True,
            "formatter": short,
            "fontSize": 10,
            "color": ink.faint if not kept else "#10151a" if dark_text else "#ffffff",
        },
        "tooltip": {"formatter": f"{name}<br>{grid_column(metric).label}: <b>{text}</b>"},
    }


def _panels(names: Sequence[str], axes: tuple[list[str], list[str]], ink: Theme) -> Chart:
    """Places, titles and axes of small panels, two abreast."""
    abreast = 1 if len(names) == 1 else 2
    rows = -(-len(names) // abreast)
    wide, tall = 100 / abreast, 85 / rows
    gap = 15 + 6 * max(map(len, axes[1]))  # px: the tick labels, at 10 px
    margin = (gap + 12) / _HEAT_PX * 100
    grids, titles, xs, ys = [], [], [], []
    for i, name in enumerate(names):
        left, top = wide * (i % abreast), tall * (i // abreast)
        grids.append(
            {
                "left": f"{left + margin}%",
                "top": f"{top + 7}%",
                "width": f"{wide - margin - 1}%",
                "height": f"{tall - 17}%",
            }
        )
        titles.append(
            {
                "text": name,
                "left": f"{left + margin}%",
                "top": f"{top}%",
                "textStyle": {"fontSize": 11, "fontWeight": 600, "color": ink.text},
            }
        )
        style = {"axisLabel": {"color": ink.faint, "fontSize": 10}, "axisTick": {"show": False}, "gridIndex": i}
        named = {"nameLocation": "middle", "nameTextStyle": {"color": ink.faint, "fontSize": 10}, **style}
        line = {"axisLine": {"lineStyle": {"color": ink.line}}}
        last = i // abreast == rows - 1
        xs.append(
            {"data": axes[0], "type": "category", "name": "T (mm)" if last else "", "nameGap": 20, **named, **line}
        )
        first = i % abreast == 0
        ys.append(
            {"data": axes[1], "type": "category", "name": "H (mm)" if first else "", "nameGap": gap, **named, **line}
        )
    return {"grid": grids, "title": titles, "xAxis": xs, "yAxis": ys}


def pareto_front(points: Sequence[tuple[int, float, float]]) -> list[int]:
    """Numbers of the non-dominated points (number, x, y), ascending in x; both are minimised."""
    front: list[int] = []
    least = math.inf
    for number, _, y in sorted(points, key=lambda point: (point[1], point[2])):
        if y < least:
            front.append(number)
            least = y
    return front


def scatter_chart(grid: SpecificationGrid, axes: tuple[str, str], chosen: Selection, ink: Theme) -> Chart:
    """Scatter chart of all designs by two columns, with the Pareto front of the matching ones."""
    points = [
        (i, x, y)
        for i, row in enumerate(grid.designs)
        if (x := _figure(row[axes[0]])) is not None and (y := _figure(row[axes[1]])) is not None
    ]
    kept = [point for point in points if point[0] in chosen.selected]
    places = {number: (x, y) for number, x, y in points}
    front = pareto_front(kept)
    dots = [_scatter_dot(point, grid.designs[point[0]], axes, (chosen, front, ink)) for point in points]
    return {
        "grid": {"left": 48, "right": 12, "top": 12, "bottom": 40},
        "xAxis": value_axis(grid_column(axes[0]).label, ink, 26),
        "yAxis": value_axis(grid_column(axes[1]).label, ink, 34),
        "tooltip": {"appendToBody": True},
        "animation": False,
        "series": [
            {
                "type": "line",
                "name": "front",
                "data": [places[number] for number in front],
                "step": "end",
                "symbol": "none",
                "silent": True,
                "lineStyle": {"color": ink.faint, "width": 1.5, "type": "dashed"},
            },
            {"type": "scatter", "name": "designs", "data": dots},
        ],
        "aria": {
            "enabled": True,
            "label": {
                "description": f"{grid_column(axes[1]).label} over {grid_column(axes[0]).label} of all designs."
            },
        },
    }


def _scatter_dot(
    point: tuple[int, float, float], row: Row, axes: tuple[str, str], how: tuple[Selection, list[int], Theme]
) -> Chart:
    number, x, y = point
    chosen, front, ink = how
    marked = {chosen.design: FIRST, chosen.other: SECOND}.get(number)
    kept = number in chosen.selected
    name = design_label(row)
    return {
        "name": name,
        "value": [x, y, number],
        "symbolSize": 15 if marked else 10 if number in front else 7,
        "itemStyle": {
            "color": marked or (VIRIDIS[5] if number in front else ink.faint),
            "opacity": 1.0 if marked or (kept and number in front) else 0.55 if kept else 0.12,
            "borderColor": ink.ground,
            "borderWidth": 1,
        },
        "tooltip": {
            "formatter": "<br>".join(
                [
                    name,
                    *(f"{(c := grid_column(axis)).label}: {c.text(v)}" for axis, v in zip(axes, (x, y), strict=True)),
                ]
            )
        },
    }


def line_chart(
    curves: Sequence[ChartCurve], axes: tuple[str, str], ink: Theme, marks: Sequence[ChartCurve] = ()
) -> Chart:
    """Curves over one pair of axes; each mark becomes a vertical line with its name at its first point."""
    uprights = [
        {
            "xAxis": mark.points[0][0],
            "name": mark.name,
            "lineStyle": {"color": mark.colour, "type": "dashed" if mark.dashed else "solid", "width": 1.2},
            "label": {"show": False},
        }
        for mark in marks
    ]
    series = [_line(curve) for curve in curves]
    if series:
        series[0]["markLine"] = {"symbol": "none", "data": uprights, "silent": True, "animation": False}
    return {
        "grid": {"left": 44, "right": 14, "top": 26, "bottom": 36},
        "legend": {
            "show": len(curves) > 1,
            "data": [curve.name for curve in curves if len(curves) < 3 or not curve.dashed],
            "top": 0,
            "itemWidth": 18,
            "itemHeight": 8,
            "textStyle": {"color": ink.text, "fontSize": 10},
        },
        "tooltip": {"trigger": "axis", "appendToBody": True},
        "xAxis": {**value_axis(axes[0], ink, 24), "min": 0},
        "yAxis": {**value_axis(axes[1], ink, 32), "min": 0},
        "animation": False,
        "series": series,
        "aria": {"enabled": True, "label": {"description": f"{axes[1]} over {axes[0]}."}},
    }


def _line(curve: ChartCurve) -> Chart:
    return {
        "type": "line",
        "name": curve.name,
        "data": [[round(x, 6), float(f"{y:.5g}")] for x, y in curve.points],
        "symbolSize": 4,
        "itemStyle": {"color": curve.colour},
        "lineStyle": {"color": curve.colour, "width": 2, "type": "dashed" if curve.dashed else "solid"},
    }


def value_axis(name: str, ink: Theme, gap: int) -> Chart:
    """Axis of numbers with its name at a distance in px."""
    return {
        "type": "value",
        "scale": True,
        "name": name,
        "nameLocation": "middle",
        "nameGap": gap,
        "nameTextStyle": {"color": ink.text, "fontSize": 11},
        "axisLabel": {"color": ink.faint, "fontSize": 10, "hideOverlap": True},
        "axisLine": {"lineStyle": {"color": ink.line}},
        "splitLine": {"lineStyle": {"color": ink.line, "opacity": 0.6}},
    }


def _figure(cell: Cell) -> float | None:
    return float(cell) if isinstance(cell, int | float) and math.isfinite(cell) else None
