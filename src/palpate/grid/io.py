"""A grid as a folder: numbers as CSV and JSON, pictures as PNG and SVG."""

from __future__ import annotations

import csv
import json
import os
import tempfile
from pathlib import Path

from palpate.core import PalpateError
from palpate.grid.grid import SpecificationGrid, unit_of
from palpate.grid.panel import cut_depth_panels, cut_panels

FORMAT, FORMAT_VERSION = "palpate specification grid", 1

HEAT_MAPS = {
    "rmse_deg": "RMSE of the contact angle, clean images",
    "max_error_deg": "Greatest error of the contact angle, clean images",
    "rmse_jitter_deg": "RMSE of the contact angle, jittered images",
    "max_error_jitter_deg": "Greatest error of the contact angle, jittered images",
}
TRAVEL = "travel_mm"
DEPTH_CURVES = {
    "": "RMSE of the contact angle by depth, clean images",
    "_jitter": "RMSE of the contact angle by depth, jittered images",
}


def write_grid(directory: Path, grid: SpecificationGrid) -> None:
    """Write a grid into a folder, replacing an older one.

    Every file is made aside and renamed when all of them are whole, so a run that stops half-way leaves the older
    grid as it was.

    Parameters
    ----------
    directory
        Made if it does not exist. Gets ``grid.csv``, ``grid.json``, one ``heat_map_….png`` and ``.svg`` for each
        of the four errors, and ``marker_travel``, ``error_by_depth`` and ``error_by_depth_jitter`` as both.
    grid
        At least one row; a grid without rows has no pictures.

    Raises
    ------
    PalpateError
        If the folder cannot be written.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".writing-", dir=directory) as name:
            drafts = Path(name)
            _write_csv(drafts / "grid.csv", grid)
            _write_json(drafts / "grid.json", grid)
            if grid.rows:
                _write_pictures(drafts, grid)
            for draft in sorted(drafts.iterdir()):
                os.replace(draft, directory / draft.name)
    except OSError as error:
        raise PalpateError(
            f"The grid cannot be written to {directory}: {error.strerror or error}.", "Choose another folder."
        ) from error


def read_grid(directory: Path) -> SpecificationGrid:
    """Read the ``grid.json`` of a folder written by `write_grid`.

    Raises
    ------
    PalpateError
        If there is none, or it is not a grid.
    """
    path = directory / "grid.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["format"] != FORMAT or content["version"] != FORMAT_VERSION:
            raise ValueError(f"it is not a {FORMAT} of version {FORMAT_VERSION}")
        columns = tuple(content["columns"])
        rows = tuple({name: row[name] for name in columns} for row in content["rows"])
    except FileNotFoundError:
        raise PalpateError(f"{directory} has no grid.json.", "Give the result folder of a finished study.") from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise PalpateError(f"{path} cannot be read as a grid: {error}.", "Run the study again.") from error
    return SpecificationGrid(rows=rows, columns=columns)


def _write_csv(path: Path, grid: SpecificationGrid) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, grid.columns)
        writer.writeheader()
        writer.writerows({name: "" if cell is None else cell for name, cell in row.items()} for row in grid.rows)


def _write_json(path: Path, grid: SpecificationGrid) -> None:
    content = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "columns": list(grid.columns),
        "units": {name: unit_of(name) for name in grid.columns if unit_of(name)},
        "rows": [dict(row) for row in grid.rows],
    }
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _write_pictures(directory: Path, grid: SpecificationGrid) -> None:
    # imported here because a drawing library loads slowly
    from palpate.grid.draw import draw_errors_by_depth, draw_heat_maps, draw_travel, write_picture

    for column, title in HEAT_MAPS.items():
        figure = draw_heat_maps(cut_panels(grid, column), title, unit_of(column))
        write_picture(directory / f"heat_map_{column.removesuffix('_deg')}", figure)
    travel = draw_travel(cut_panels(grid, TRAVEL), "Marker travel from rest at the greatest depth")
    write_picture(directory / "marker_travel", travel)
    for suffix, title in DEPTH_CURVES.items():
        curves = draw_errors_by_depth(cut_depth_panels(grid, suffix), title)
        write_picture(directory / f"error_by_depth{suffix}", curves)
