"""`palpate grid`: look at the specification grid of a finished study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter

from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table

COLUMNS = (
    "height_mm",
    "thickness_mm",
    "markers",
    "rmse_deg",
    "max_error_deg",
    "rmse_jitter_deg",
    "max_error_jitter_deg",
    "travel_mm",
    "peak_stress_mpa",
    "force_n",
    "presses",
    "samples",
)
"""Columns of the printed table; the files hold every column."""

app = App(name="grid", help="Look at a specification grid.")


@app.command
def show(
    directory: Annotated[Path, Parameter(help="Result folder of a study, with its grid.json.")],
    *,
    where: Annotated[str | None, Parameter(help="Keep rows, e.g. 'markers >= 91 and rmse_deg < 0.5'.")] = None,
    sort: Annotated[
        str | None, Parameter(allow_leading_hyphen=True, help="Column to sort by; a leading minus reverses.")
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Show the grid of a result folder, its rows chosen and sorted."""
    from palpate.grid import filter_rows, read_grid, sort_rows

    rows = read_grid(directory).rows
    rows = rows if where is None else filter_rows(rows, where)
    rows = rows if sort is None else sort_rows(rows, sort)
    if json:
        print_json(rows)
    else:
        print_grid(str(directory), rows)


def print_grid(title: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Print the main columns of a grid.

    Parameters
    ----------
    title
        Name of the study or of its folder.
    rows
        One mapping a design, from column to value.
    """
    columns = [name for name in COLUMNS if any(name in row for row in rows)]
    print_table(title, [name.replace("_", " ") for name in columns], [_cells(row, columns) for row in rows])


def _cells(row: Mapping[str, Any], columns: Sequence[str]) -> list[str]:
    return [_cell(row.get(name)) for name in columns]


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.3f}" if isinstance(value, float) and not value.is_integer() else f"{value:g}"
