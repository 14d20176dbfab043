"""A grid for other programs: CSV, Parquet, Markdown."""

from __future__ import annotations

import csv
import html
from collections.abc import Callable, Sequence
from pathlib import Path

from palpate.core import PalpateError, atomic_write, load_extra
from palpate.grid.grid import MAIN_COLUMNS, TABLES, Cell, Row, SpecificationGrid, column_unit, design_label

CSV_COLUMNS = (
    "height_mm",
    "base_radius_mm",
    "thickness_mm",
    "shape",
    "markers",
    "rmse_deg",
    "max_error_deg",
    "rmse_jitter_deg",
    "max_error_jitter_deg",
    "rmse_mm",
    "max_error_mm",
    "rmse_jitter_mm",
    "max_error_jitter_mm",
    "rmse_spread_deg",
    "rmse_depth_mm",
    "bound_deg",
    "bound_mm",
    "bound_pitman_deg",
    "rmse_over_bound",
    "interval_coverage",
    "interval_half_width_deg",
    "travel_mm",
    "peak_stress_mpa",
    "peak_stress_straight_mpa",
    "force_n",
    "bistable_from_mm",
    "presses",
    "presses_inverted",
    "samples",
    "dropped",
    "ended",
    "seed",
    "failure",
)
"""Columns of a design in CSV, behind its name: those that decide. SQLite, JSON and Parquet have all."""


def export_grid(path: Path, grid: SpecificationGrid) -> tuple[Path, ...]:
    """Write a grid to `path`, replacing it; the ending chooses the form.

    Parameters
    ----------
    path
        ``.csv`` gets the columns that decide, ``.parquet`` all, ``.md`` the main ones for people. The tables by
        depth, by tilt and of presses stand beside the first two: ``grid_by_depth.csv``, … beside ``grid.csv``.
    grid
        The designs to write.

    Returns
    -------
    tuple[Path, ...]
        The files that were written.

    Raises
    ------
    PalpateError
        If the ending is another, or a file cannot be written.
    MissingExtraError
        If Parquet is asked for and pyarrow is not installed.
    """
    writer = _WRITERS.get(path.suffix.lower())
    if writer is None:
        raise PalpateError(
            f"A grid cannot be written as '{path.name}'.",
            f"Let the name end in {', '.join(_WRITERS)}.",
            code="file-ending-unknown",
        )
    with atomic_write(path) as draft:
        writer(draft, grid)
        names = sorted(made.name for made in draft.parent.iterdir())
    return tuple(path.parent / name for name in names)


def write_csv(path: Path, grid: SpecificationGrid, other: str = "{stem}_{table}") -> None:
    """Write the four tables as CSV; a cell without a figure is empty.

    Parameters
    ----------
    path
        File of the designs: their names and the columns of `CSV_COLUMNS` that they have.
    grid
        The grid.
    other
        How the files of the other tables are named, from ``stem`` of the file and ``table``.
    """
    names = [design_label(row) for row in grid.designs]
    columns = [name for name in CSV_COLUMNS if name in grid.columns]
    rows = zip(names, grid.designs, strict=True)
    _write_rows(path, [{"name": name, **{column: row[column] for column in columns}} for name, row in rows])
    for table in TABLES:
        numbered: Sequence[Row] = getattr(grid, table)
        file = path.with_name(other.format(stem=path.stem, table=table) + path.suffix)
        _write_rows(file, [{"name": names[int(str(row["design"]))], **row} for row in numbered])


def _write_rows(path: Path, rows: Sequence[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else ["name"])
        writer.writeheader()
        writer.writerows({name: "" if cell is None else cell for name, cell in row.items()} for row in rows)


def _write_parquet(path: Path, grid: SpecificationGrid) -> None:
    _write_columns(path, grid.designs)
    for table in TABLES:
        _write_columns(path.with_name(f"{path.stem}_{table}{path.suffix}"), getattr(grid, table))


def _write_columns(path: Path, rows: Sequence[Row]) -> None:
    pyarrow = load_extra("pyarrow", "parquet")
    parquet = load_extra("pyarrow.parquet", "parquet", "pyarrow")
    fields, arrays = [], []
    for name in rows[0] if rows else ():
        cells = [row[name] for row in rows]
        texts = any(isinstance(cell, str) for cell in cells)
        known = [cell for cell in cells if cell is not None]
        whole = bool(known) and all(isinstance(cell, int) for cell in known)
        kind = pyarrow.string() if texts else pyarrow.int64() if whole else pyarrow.float64()
        unit = column_unit(name)
        fields.append(pyarrow.field(name, kind, metadata={"unit": unit} if unit else None))
        arrays.append(pyarrow.array(cells, kind))
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), path)


def _write_markdown(path: Path, grid: SpecificationGrid) -> None:
    columns = [name for name in MAIN_COLUMNS if name in grid.columns]
    lines = [_line([_heading(name) for name in columns]), _line(["---:"] * len(columns))]
    lines += [_line([_text(row[name]) for name in columns]) for row in grid.designs]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def html_rows(grid: SpecificationGrid) -> str:
    """The main columns as an HTML table, a row a design, its texts escaped."""
    columns = [name for name in MAIN_COLUMNS if name in grid.columns]
    head = "".join(f"<th>{html.escape(_heading(name))}</th>" for name in columns)
    rows = ["".join(f"<td>{html.escape(_text(row[name]))}</td>" for name in columns) for row in grid.designs]
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


_WRITERS: dict[str, Callable[[Path, SpecificationGrid], None]] = {
    ".csv": write_csv,
    ".parquet": _write_parquet,
    ".md": _write_markdown,
}


def _line(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _heading(column: str) -> str:
    unit = column_unit(column)
    words = column.rsplit("_", 1)[0] if unit else column
    return words.replace("_", " ") + (f" ({unit})" if unit else "")


def _text(cell: Cell) -> str:
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell.replace("|", "\\|")
    return f"{cell:.3f}" if isinstance(cell, float) and not cell.is_integer() else f"{cell:g}"
