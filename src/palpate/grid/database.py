"""A grid as an SQLite file, so that other programs can ask it.

    design      one row a design: every figure that belongs to the design as a whole
    by_depth    one row a design and depth: rmse_deg, max_error_deg, limit_deg, …
    by_tilt     one row a design and interval of tilt
    provenance  one row a design and fact: keys of its artefacts down to the presses, versions, spec (JSON)
    grid        names of the columns, in order

It is written in one transaction of a database in WAL mode: whoever reads meanwhile sees the older grid.
"""

from __future__ import annotations

import json
import re
import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from palpate.core import PalpateError
from palpate.grid.grid import Cell, Row, SpecificationGrid, depth_of, tilts_of

SCHEMA_VERSION = 1
APPLICATION = 0x70616C70
"""Marks the file as ours in its header: "palp"."""
WAIT_S = 30.0
"""How long to wait for another writer, s."""

DEPTH, TILT = ("depth_mm",), ("tilt_from_deg", "tilt_to_deg")
Table = dict[tuple[float, ...], dict[str, Cell]]
"""Cells of one design by place (depth or interval of tilt), then by figure."""


def write_database(path: Path, grid: SpecificationGrid) -> None:
    """Write a grid into the SQLite file `path`; an older grid in it is replaced, a file that is none too.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    try:
        try:
            _write(path, grid)
        except sqlite3.OperationalError:
            raise
        except sqlite3.DatabaseError:  # not a database, or a broken one: the grid is made again from the study
            path.unlink()
            _write(path, grid)
    except sqlite3.Error as error:
        raise OSError(f"{path.name}: {error}") from error


def read_database(path: Path) -> SpecificationGrid:
    """Read a grid written by `write_database`.

    Raises
    ------
    PalpateError
        If the file is not a grid, or is one of another schema.
    """
    try:
        try:
            return _read(path, "mode=ro")
        except sqlite3.OperationalError:  # a folder without the right to write, where WAL cannot keep its index
            return _read(path, "mode=ro&immutable=1")
    except (sqlite3.Error, ValueError, KeyError, TypeError, IndexError) as error:
        raise PalpateError(f"{path} cannot be read as a grid: {error}.", "Run the study again.") from error


def _write(path: Path, grid: SpecificationGrid) -> None:
    with closing(sqlite3.connect(path, timeout=WAIT_S, isolation_level=None)) as database:
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("BEGIN IMMEDIATE")
        for name in ("design", "by_depth", "by_tilt", "provenance", "grid"):
            database.execute(f"DROP TABLE IF EXISTS {name}")
        plain = [name for name in grid.columns if not (depth_of(name) or tilts_of(name) or _is_provenance(name))]
        designs = [{"design": number, **{name: row[name] for name in plain}} for number, row in enumerate(grid.rows)]
        _fill(database, "design", ["design", *plain], designs)
        for table, keys, cut in (("by_depth", DEPTH, _by_depth), ("by_tilt", TILT, _by_tilt)):
            rows = [
                {"design": number, **dict(zip(keys, place, strict=True)), **cells}
                for number, row in enumerate(grid.rows)
                for place, cells in cut(row).items()
            ]
            _fill(database, table, ["design", *keys, *dict.fromkeys(name for row in rows for name in row)], rows)
        facts = [fact for number, row in enumerate(grid.rows) for fact in _provenance(number, row)]
        _fill(database, "provenance", ["design", "kind", "number", "value"], facts)
        _fill(database, "grid", ["columns"], [{"columns": json.dumps(grid.columns)}])
        database.execute(f"PRAGMA application_id = {APPLICATION}")
        database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
        database.execute("COMMIT")


def _read(path: Path, mode: str) -> SpecificationGrid:
    with closing(sqlite3.connect(f"{path.resolve().as_uri()}?{mode}", uri=True, timeout=WAIT_S)) as database:
        database.row_factory = sqlite3.Row
        marks = [database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")]
        if marks != [APPLICATION, SCHEMA_VERSION]:
            raise ValueError(f"it is not a grid of schema {SCHEMA_VERSION}")
        columns = tuple(json.loads(database.execute("SELECT columns FROM grid").fetchone()[0]))
        cells: list[dict[Any, Any]] = [dict(row) for row in database.execute("SELECT * FROM design ORDER BY design")]
        for table, keys in (("by_depth", DEPTH), ("by_tilt", TILT)):
            for row in database.execute(f"SELECT * FROM {table}"):
                cells[row["design"]][table, *(row[key] for key in keys)] = dict(row)
        for row in database.execute("SELECT * FROM provenance ORDER BY design, kind, number"):
            cells[row["design"]].setdefault(row["kind"], []).append(row["value"])
    rows = tuple({name: _cell(found, name) for name in columns} for found in cells)
    return SpecificationGrid(rows=rows, columns=columns)


def _cell(found: dict[Any, Any], column: str) -> Cell:
    """One cell of a design from all that was found of it."""
    value: Any
    if at_depth := depth_of(column):
        row = found.get(("by_depth", at_depth[1]))
        value = row.get(at_depth[0]) if isinstance(row, dict) else None
    elif at_tilt := tilts_of(column):
        row = found.get(("by_tilt", *at_tilt[1:]))
        value = row.get(at_tilt[0]) if isinstance(row, dict) else None
    else:
        value = found.get(column)
    if isinstance(value, list):
        return " ".join(value)
    if value is None or isinstance(value, int | float | str):
        return value
    raise ValueError(f"{column} holds {type(value).__name__}")


def _by_depth(row: Row) -> Table:
    table: Table = {}
    for name, cell in row.items():
        if (at := depth_of(name)) and cell is not None:
            table.setdefault((at[1],), {})[at[0]] = cell
    return table


def _by_tilt(row: Row) -> Table:
    table: Table = {}
    for name, cell in row.items():
        if (at := tilts_of(name)) and cell is not None:
            table.setdefault(at[1:], {})[at[0]] = cell
    return table


def _is_provenance(column: str) -> bool:
    return column.endswith("_key") or column in ("versions", "spec")


def _provenance(number: int, row: Row) -> Iterable[dict[str, Cell]]:
    for name in filter(_is_provenance, row):
        cell = row[name]
        if isinstance(cell, str):
            parts = re.split(r" (?=[\w-]+=)", cell) if name == "versions" else [cell]
            parts = cell.split(" ") if name.endswith("_key") else parts
            for place, part in enumerate(parts):
                yield {"design": number, "kind": name, "number": place, "value": part}


def _fill(database: sqlite3.Connection, table: str, names: Sequence[str], rows: Sequence[Row]) -> None:
    """Make a table with one column a name and fill it."""
    columns = tuple(dict.fromkeys(names))
    declared = ", ".join(f'"{name}" {_affinity([row.get(name) for row in rows])}' for name in columns)
    database.execute(f"CREATE TABLE {table} ({declared})")
    marks = ", ".join("?" * len(columns))
    cells = [[row.get(name) for name in columns] for row in rows]
    database.executemany(f"INSERT INTO {table} VALUES ({marks})", cells)


def _affinity(cells: Sequence[Cell]) -> str:
    if any(isinstance(cell, str) for cell in cells):
        return "TEXT"
    return "REAL" if any(isinstance(cell, float) for cell in cells) else "INTEGER"
