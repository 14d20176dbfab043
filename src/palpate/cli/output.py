"""What a command prints, and where it may write: JSON for machines, tables for people, files looked at beforehand."""

from __future__ import annotations

import json
import math
import os
import sys
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from palpate.core import PalpateError

RESULTS = Path("results")
"""Folder of the result folders, where --out does not choose one."""
PIPE_WIDTH = 160
"""Columns of text where no terminal says how many there are."""


def print_json(content: Any) -> None:
    """Print `content` as strict JSON on standard output; numbers that are not finite become null."""
    print(json.dumps(_finite(content), indent=2, allow_nan=False))


def print_table(title: str, columns: list[str], rows: list[list[str]]) -> None:
    """Print a table, numbers to the right, as wide as it must be where no terminal limits it."""
    console = Console(width=None if sys.stdout.isatty() else PIPE_WIDTH, markup=False)  # an extra is written [so]
    table = Table(title=title, title_justify="left")
    for column in columns:
        table.add_column(column, justify="right" if _are_numbers(rows, columns.index(column)) else "left")
    for row in rows:
        table.add_row(*row)
    console.print(table)


def check_file(path: Path | None, *endings: str) -> None:
    """Refuse a file that could not be written, before anything is computed; `None` is fine.

    Raises
    ------
    PalpateError
        If its name has none of the endings, if given, or it is a folder, or its folder is not there or read-only.
    """
    if path is None:
        return
    if endings and path.suffix.lower() not in endings:
        raise PalpateError(
            f"{path.name} does not end in {' or '.join(endings)}.", "Name the file so.", code="file-ending-unknown"
        )
    if path.is_dir():
        raise PalpateError(f"{path} is a folder.", "Name a file in it.", code="file-is-folder")
    if not path.parent.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        reason = "may not be written to" if path.parent.is_dir() else "is no folder"
        raise PalpateError(
            f"{path} cannot be written: {path.parent} {reason}.",
            "Name a file in another folder.",
            code="file-unwritable",
        )


def check_folder(path: Path | None) -> None:
    """Refuse a folder that could neither be made nor written to, before anything is computed; `None` is fine.

    Raises
    ------
    PalpateError
        If it, or the nearest folder above it that is there, is a file or read-only.
    """
    if path is None:
        return
    there = next(place for place in (path, *path.absolute().parents) if place.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        reason = "may not be written to" if there.is_dir() else "is a file"
        raise PalpateError(
            f"The folder {path} cannot be written: {there} {reason}.",
            "Choose another folder.",
            code="folder-unwritable",
        )


def _are_numbers(rows: list[list[str]], column: int) -> bool:
    return all(row[column].lstrip("-").replace(".", "", 1).isdigit() for row in rows if row[column])


def _finite(content: Any) -> Any:
    if isinstance(content, dict):
        return {str(key): _finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content
