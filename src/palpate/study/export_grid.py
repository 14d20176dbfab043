"""A grid for other programs: CSV, Parquet, Markdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from palpate.core import PalpateError, atomic_write, load_extra
from palpate.core.report import Report, report_html, report_markdown, write_csv
from palpate.study.grid import TABLES, Row, SpecificationGrid, column_unit, design_label
from palpate.study.grid_columns import CSV_COLUMNS, MAIN_COLUMNS, grid_column


def export_grid(path: Path, grid: SpecificationGrid) -> tuple[Path, ...]:
    """Write a grid to `path`, replacing it; the ending selects the format.

    Parameters
    ----------
    path
        ``.csv`` gets the columns that decide, ``.parquet`` all, ``.md`` the main ones. The tables by depth, by tilt
        and of presses are written next to the first two: ``grid_by_depth.csv``, … next to ``grid.csv``.
    grid
        The designs to write.

    Returns
    -------
    tuple[Path, ...]
        The files that were written.

    Raises
    ------
    PalpateError
        If the ending is unknown, or a file cannot be written.
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


def write_tables(path: Path, grid: SpecificationGrid, other: str = "{stem}_{table}") -> None:
    """Write the four tables as CSV; a cell without a figure is empty.

    Parameters
    ----------
    path
        File of the designs: their names and the columns of `CSV_COLUMNS` that they have.
    grid
        The grid.
    other
        Format of the file names of the remaining tables, from ``stem`` of the file and ``table``.
    """
    names = [design_label(row) for row in grid.designs]
    columns = [name for name in CSV_COLUMNS if name in grid.columns]
    designs = [{"name": name, **row} for name, row in zip(names, grid.designs, strict=True)]
    write_csv(path, designs, ["name", *columns])
    for table in TABLES:
        numbered: Sequence[Row] = getattr(grid, table)
        file = path.with_name(other.format(stem=path.stem, table=table) + path.suffix)
        rows = [{"name": names[int(str(row["design"]))], **row} for row in numbered]
        write_csv(file, rows, ["name", *(numbered[0] if numbered else ())])


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
    path.write_text(report_markdown(grid_report(grid.designs, MAIN_COLUMNS)), encoding="utf-8")


def html_rows(grid: SpecificationGrid) -> str:
    """Return the main columns as an HTML table, a row a design, texts escaped."""
    return report_html(grid_report(grid.designs, MAIN_COLUMNS))


def grid_report(rows: Sequence[Row], columns: Sequence[str] = (), title: str = "", file: str = "") -> Report:
    """Make a table of the designs of a grid.

    Parameters
    ----------
    rows
        One a design.
    columns
        Names of the columns, of which those that the rows have are shown; the main ones and those of a CSV if empty.
    title, file
        Title of the table, and a file that has all columns.
    """
    names = columns or dict.fromkeys((*MAIN_COLUMNS, *CSV_COLUMNS))
    return Report(title, [grid_column(name) for name in names if any(name in row for row in rows)], rows, (), file)


_WRITERS: dict[str, Callable[[Path, SpecificationGrid], None]] = {
    ".csv": write_tables,
    ".parquet": _write_parquet,
    ".md": _write_markdown,
}
