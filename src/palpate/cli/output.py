"""What a command prints: JSON for machines, tables for people."""

from __future__ import annotations

import json
import math
import sys
from typing import Any

from rich.console import Console
from rich.table import Table

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
