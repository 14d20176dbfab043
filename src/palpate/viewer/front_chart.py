"""Front of a search as data for ECharts: error over another objective, with trials and winner."""

from __future__ import annotations

from palpate.optimise import SearchFolder
from palpate.viewer.charts import FIRST, SECOND, VIRIDIS, Chart, Theme, value_axis
from palpate.viewer.labels import column_label, find_column

ERROR = "p95_deg"
"""Column of the minimised error."""
COARSE = "front, coarse presses only"
"""Role of a non-dominated design without fine presses."""
COLUMNS = {"force": "force_n", "markers": "markers", "price": "price", "size": "size_mm"}
"""Columns of the remaining objectives."""


def front_chart(search: SearchFolder, across: str, chosen: int, ink: Theme) -> Chart:
    """All designs of a search by their error over a column; each point's value ends in its number."""
    numbers = range(len(search.rows))
    parts = (
        (
            "tried",
            [k for k in numbers if k >= search.front + search.coarse],
            {"color": ink.faint, "opacity": 0.45},
            7,
        ),
        (COARSE, [k for k in numbers if role_of(search, k) == COARSE], {"color": "#e69f00"}, 8),
        ("front", [k for k in numbers if k < search.front and k != search.winner], {"color": VIRIDIS[5]}, 10),
        ("winner", [search.winner] if search.winner >= 0 else [], {"color": SECOND}, 17),
    )
    series = [
        {
            "type": "scatter",
            "name": name,
            "symbol": "diamond" if name == "winner" else "circle",
            "symbolSize": size,
            "itemStyle": {**style, "borderColor": ink.ground, "borderWidth": 1},
            "data": [_dot(search, k, across, k == chosen) for k in members],
        }
        for name, members, style, size in parts
    ]
    return {
        "grid": {"left": 52, "right": 14, "top": 30, "bottom": 40},
        "legend": {
            "data": [part["name"] for part in series if part["data"]],
            "top": 0,
            "itemWidth": 10,
            "itemHeight": 10,
            "textStyle": {"color": ink.text, "fontSize": 10},
        },
        "xAxis": value_axis(column_label(across), ink, 26),
        "yAxis": value_axis(column_label(ERROR), ink, 38),
        "tooltip": {"appendToBody": True},
        "animation": False,
        "series": series,
        "aria": {
            "enabled": True,
            "label": {"description": f"{column_label(ERROR)} over {column_label(across)} of all designs."},
        },
    }


def _dot(search: SearchFolder, number: int, across: str, chosen: bool) -> Chart:
    row = search.rows[number]
    x, y = float(row[across]), float(row[ERROR])
    words = "<br>".join(
        [
            design_words(search, number),
            *(f"{column_label(n)}: {find_column(n).text(v)}" for n, v in ((across, x), (ERROR, y))),
        ]
    )
    marked = (
        {"itemStyle": {"borderColor": FIRST, "borderWidth": 3, "opacity": 1.0}, "symbolSize": 17} if chosen else {}
    )
    return {"name": f"design {number}", "value": [x, y, number], "tooltip": {"formatter": words}, **marked}


def design_words(search: SearchFolder, number: int) -> str:
    """Return the label of a design, e.g. ``"skin 12, 91 markers: winner"``."""
    row, role = search.rows[number], role_of(search, number)
    words = "tried, breaks a limit" if role == "tried" and not row["feasible"] else role
    return f"skin {row['skin']}, {row['markers']} markers: {words}"


def role_of(search: SearchFolder, number: int) -> str:
    """Return the role of a design in its search: ``"winner"``, ``"front"``, `COARSE` or ``"tried"``."""
    if number >= search.front:
        return COARSE if number < search.front + search.coarse else "tried"
    return "winner" if number == search.winner else "front"
