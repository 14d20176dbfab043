"""A grid as an SQLite file for other programs.

    design      one row a design: every figure that belongs to the design as a whole
    by_depth    one row a design and depth: rmse_deg, max_error_deg, bound_deg, …
    by_tilt     one row a design and interval of tilt
    presses     one row a design and press: tilt_deg, ended, branch, force_n, …
    provenance  one row a design and fact: keys of its artefacts down to the presses, versions, spec (JSON)

It is written in one transaction of a database in WAL mode: concurrent readers see the older grid.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from palpate.core import PalpateError, rename_columns
from palpate.study.grid import Cell, Row, SpecificationGrid

SCHEMA_VERSION = 2
"""Version of the tables."""
APPLICATION = 0x70616C70
"""Application id of the file, in its header: "palp"."""
WAIT_S = 30.0
"""Timeout for another writer, s. By hand."""

KEYS = {"by_depth": ("depth_mm",), "by_tilt": ("tilt_from_deg", "tilt_to_deg"), "presses": ()}
"""Columns of each table of details, after the design's number."""


def write_database(path: Path, grid: SpecificationGrid) -> None:
    """Write a grid into the SQLite file `path`, replacing an older grid or another file.

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
        raise PalpateError(
            f"{path} cannot be read as a grid: {error}.", "Run the study again.", code="grid-unreadable"
        ) from error


def _write(path: Path, grid: SpecificationGrid) -> None:
    with closing(sqlite3.connect(path, timeout=WAIT_S, isolation_level=None)) as database:
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("BEGIN IMMEDIATE")
        for name in ("design", *KEYS, "provenance", "grid"):  # the last is of schema 1
            database.execute(f"DROP TABLE IF EXISTS {name}")
        plain = [name for name in grid.columns if not _is_provenance(name)]
        designs = [
            {"design": number, **{name: row[name] for name in plain}} for number, row in enumerate(grid.designs)
        ]
        _fill(database, "design", ["design", *plain], designs)
        for table, keys in KEYS.items():
            rows: tuple[Row, ...] = getattr(grid, table)
            _fill(database, table, ["design", *keys, *(rows[0] if rows else ())], rows)
        facts = [fact for number, row in enumerate(grid.designs) for fact in _provenance(number, row)]
        _fill(database, "provenance", ["design", "kind", "name", "value"], facts)
        database.execute(f"PRAGMA application_id = {APPLICATION}")
        database.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")
        database.execute("COMMIT")


def _read(path: Path, mode: str) -> SpecificationGrid:
    with closing(sqlite3.connect(f"{path.resolve().as_uri()}?{mode}", uri=True, timeout=WAIT_S)) as database:
        database.row_factory = sqlite3.Row
        marks = [database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")]
        if marks[0] != APPLICATION:
            raise ValueError("it is no grid")
        check_schema_version(path, marks[1], SCHEMA_VERSION)
        designs = [rename_columns(dict(row)) for row in database.execute("SELECT * FROM design ORDER BY design")]
        for number, row in enumerate(designs):
            if row.pop("design") != number:
                raise ValueError("its designs are not numbered from 0")
        tables = [[rename_columns(dict(row)) for row in database.execute(f"SELECT * FROM {table}")] for table in KEYS]
        facts: dict[str, list[dict[str, str]]] = {}
        for fact in database.execute("SELECT * FROM provenance ORDER BY rowid"):
            found = facts.setdefault(fact["kind"], [{} for _ in designs])
            found[fact["design"]][fact["name"]] = fact["value"]
    for kind, found in facts.items():
        for row, parts in zip(designs, found, strict=True):
            row[kind] = _join(kind, parts) if parts else None
    for row in (row for table in (designs, *tables) for row in table):
        if not all(cell is None or isinstance(cell, int | float | str) for cell in row.values()):
            raise ValueError("a cell holds neither a number nor a text")
    return SpecificationGrid(tuple(designs), *(tuple(table) for table in tables))


def check_schema_version(path: Path, version: Any, known: int) -> None:
    """Reject a grid of another version of palpate, with a `PalpateError` that names the remedy."""
    if version != known:
        older = isinstance(version, int) and version < known
        age = "an older" if older else "another"
        raise PalpateError(
            f"{path} was written by {age} palpate: its format is {version}, this one reads {known}.",
            "Run the study again with `palpate run`: its other results stay valid, and only the grid is rewritten.",
            code="grid-older" if older else "grid-other",
        )


def _is_provenance(column: str) -> bool:
    return column.endswith("_key") or column in ("versions", "spec")


def _provenance(number: int, row: Row) -> Iterable[dict[str, Cell]]:
    for kind in filter(_is_provenance, row):
        cell = row[kind]
        if isinstance(cell, str):
            parts: dict[Any, Any] = {"": cell}
            if kind == "versions":
                parts = json.loads(cell)
            elif kind.endswith("_key"):
                parts = dict(enumerate(cell.split(" ")))
            for name, value in parts.items():
                yield {"design": number, "kind": kind, "name": str(name), "value": str(value)}


def _join(kind: str, parts: dict[str, str]) -> str:
    """Join the parts that `_provenance` separated."""
    return json.dumps(parts) if kind == "versions" else " ".join(parts.values())


def _fill(database: sqlite3.Connection, table: str, names: Sequence[str], rows: Sequence[Row]) -> None:
    """Create a table with one column a name and fill it."""
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
