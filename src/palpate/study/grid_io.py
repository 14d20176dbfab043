"""A grid as a folder: numbers as SQLite, CSV and JSON, figures as PNG and SVG."""

from __future__ import annotations

import json
from pathlib import Path

from palpate.core import PalpateError, atomic_write_into, rename_columns
from palpate.study.export_grid import write_tables
from palpate.study.grid import TABLES, SpecificationGrid, column_unit, own_column
from palpate.study.grid_database import check_schema_version, read_database, write_database
from palpate.study.plot_grid import draw_plot, plot_file_name

FORMAT, FORMAT_VERSION = "palpate specification grid", 2
"""Name and version in the header of a grid."""
DATABASE = "grid.sqlite"

BUILT = (("heat", "built_rmse_deg"), ("heat", "calibrated_p95_deg"))
"""Figures of a grid with predicted accuracy of built units."""
PICTURES = (
    ("heat", "rmse_deg"),
    ("heat", "max_error_deg"),
    ("heat", "rmse_jitter_deg"),
    ("heat", "max_error_jitter_deg"),
    ("travel", "travel_mm"),
    ("depth", "rmse_deg"),
    ("depth", "rmse_jitter_deg"),
)
"""Kind and metric of the figures of every grid."""


def write_grid(directory: Path, grid: SpecificationGrid) -> None:
    """Write a grid into a folder, replacing an older one.

    Files are written aside and renamed when all are complete, and the database changes in one transaction, so that an
    interrupted run leaves the older grid unchanged.

    Parameters
    ----------
    directory
        Made if it does not exist. Gets ``grid.sqlite`` and ``grid.json`` with everything, ``grid.csv`` with the
        columns that decide, ``by_depth.csv``, ``by_tilt.csv`` and ``presses.csv``, one ``heat_map_….png`` and
        ``.svg`` for each of the four errors, and ``marker_travel``, ``error_by_depth`` and
        ``error_by_depth_jitter`` as both.
    grid
        A grid without designs has no figures.

    Raises
    ------
    PalpateError
        If the folder cannot be written.
    """
    with atomic_write_into(directory) as drafts:
        write_tables(drafts / "grid.csv", grid, "{table}")
        _write_json(drafts / "grid.json", grid)
        if grid.designs:
            _write_pictures(drafts, grid)
        write_database(directory / DATABASE, grid)


def is_grid(directory: Path) -> bool:
    """Whether a folder holds a grid, readable or not."""
    return any((directory / name).is_file() for name in (DATABASE, "grid.json"))


def read_grid(directory: Path) -> SpecificationGrid:
    """Read the grid of a folder written by `write_grid`, from ``grid.sqlite`` or else ``grid.json``.

    Raises
    ------
    PalpateError
        If there is no grid, or an unreadable or older one.
    """
    if (directory / DATABASE).is_file():
        return read_database(directory / DATABASE)
    path = directory / "grid.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] != FORMAT:
            raise ValueError(f"it is not a {FORMAT}")
        check_schema_version(path, content["version"], FORMAT_VERSION)
        return SpecificationGrid(*(tuple(map(rename_columns, content[table])) for table in ("designs", *TABLES)))
    except FileNotFoundError:
        raise PalpateError(
            f"{directory} has no grid.json.", "Give the result folder of a finished study.", code="grid-missing"
        ) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise PalpateError(
            f"{path} cannot be read as a grid: {error}.", "Run the study again.", code="grid-unreadable"
        ) from error


def _write_json(path: Path, grid: SpecificationGrid) -> None:
    units = {name: column_unit(name) for name in grid.columns if column_unit(name)}
    parts = [f'"format": "{FORMAT}"', f'"version": {FORMAT_VERSION}', f'"units": {json.dumps(units)}']
    for table in ("designs", *TABLES):
        rows = ",\n".join(json.dumps(dict(row), allow_nan=False) for row in getattr(grid, table))
        parts.append(f'"{table}": [\n{rows}\n]')
    path.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")  # a row a line


def _write_pictures(directory: Path, grid: SpecificationGrid) -> None:
    # imported here because a drawing library loads slowly
    from palpate.study.draw_grid import write_picture

    built = (picture for picture in BUILT if picture[1] in grid.columns)
    for kind, name in (*built, *PICTURES):
        metric = own_column(grid.columns, name)
        write_picture(directory / plot_file_name(kind, metric), draw_plot(grid, kind, metric))
