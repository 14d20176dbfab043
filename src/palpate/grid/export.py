"""A grid for other programs: CSV, Parquet, Markdown."""

from __future__ import annotations

import csv
import html
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from palpate.core import PalpateError, load_extra
from palpate.grid.grid import MAIN_COLUMNS, Cell, SpecificationGrid, unit_of


def export_grid(path: Path, grid: SpecificationGrid) -> None:
    """Write a grid to `path`, replacing it; the ending chooses the form.

    Parameters
    ----------
    path
        ``.csv`` and ``.parquet`` get every column, ``.md`` the main ones for people.
    grid
        The rows to write.

    Raises
    ------
    PalpateError
        If the ending is another, or the file cannot be written.
    MissingExtraError
        If Parquet is asked for and pyarrow is not installed.
    """
    writer = _WRITERS.get(path.suffix.lower())
    if writer is None:
        raise PalpateError(
            f"A grid cannot be written as '{path.name}'.", f"Let the name end in {', '.join(_WRITERS)}."
        )
    try:
        with tempfile.TemporaryDirectory(prefix=".writing-", dir=path.parent) as folder:
            draft = Path(folder) / path.name
            writer(draft, grid)
            os.replace(draft, path)
    except OSError as error:
        raise PalpateError(f"{path} cannot be written: {error.strerror or error}.", "Choose another file.") from error


def write_csv(path: Path, grid: SpecificationGrid) -> None:
    """Write every column as CSV; a cell without a figure is empty."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, grid.columns)
        writer.writeheader()
        writer.writerows({name: "" if cell is None else cell for name, cell in row.items()} for row in grid.rows)


def _write_parquet(path: Path, grid: SpecificationGrid) -> None:
    pyarrow = load_extra("pyarrow", "parquet")
    parquet = load_extra("pyarrow.parquet", "parquet", "pyarrow")
    fields, arrays = [], []
    for name in grid.columns:
        cells = [row[name] for row in grid.rows]
        texts = any(isinstance(cell, str) for cell in cells)
        known = [cell for cell in cells if cell is not None]
        whole = bool(known) and all(isinstance(cell, int) for cell in known)
        kind = pyarrow.string() if texts else pyarrow.int64() if whole else pyarrow.float64()
        unit = unit_of(name)
        fields.append(pyarrow.field(name, kind, metadata={"unit": unit} if unit else None))
        arrays.append(pyarrow.array(cells, kind))
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), path)


def _write_markdown(path: Path, grid: SpecificationGrid) -> None:
    columns = [name for name in MAIN_COLUMNS if name in grid.columns]
    lines = [_line([_heading(name) for name in columns]), _line(["---:"] * len(columns))]
    lines += [_line([_text(row[name]) for name in columns]) for row in grid.rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def html_rows(grid: SpecificationGrid) -> str:
    """The main columns as an HTML table, a row a design, its texts escaped."""
    columns = [name for name in MAIN_COLUMNS if name in grid.columns]
    head = "".join(f"<th>{html.escape(_heading(name))}</th>" for name in columns)
    rows = ["".join(f"<td>{html.escape(_text(row[name]))}</td>" for name in columns) for row in grid.rows]
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


_WRITERS: dict[str, Callable[[Path, SpecificationGrid], None]] = {
    ".csv": write_csv,
    ".parquet": _write_parquet,
    ".md": _write_markdown,
}


def _line(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _heading(column: str) -> str:
    unit = unit_of(column)
    words = column.rsplit("_", 1)[0] if unit else column
    return words.replace("_", " ") + (f" ({unit})" if unit else "")


def _text(cell: Cell) -> str:
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell.replace("|", "\\|")
    return f"{cell:.3f}" if isinstance(cell, float) and not cell.is_integer() else f"{cell:g}"
