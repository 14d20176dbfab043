"""Reports as files: tables in Markdown, strict JSON, CSV."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from palpate.core import provenance, wrap_write_errors

Rows = Sequence[Sequence[str]]


def write_report(folder: Path, name: str, content: Any, page: str, table: Rows = ()) -> None:
    """Write ``name.json``, ``name.md`` and, where there is a table, ``name.csv`` into a folder, which is made.

    Parameters
    ----------
    folder, name
        Where, and beginning of the files' names.
    content
        JSON data; numbers that are not finite become null.
    page
        Markdown.
    table
        Rows, the first of them the columns.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    with wrap_write_errors(folder, "Choose another folder."):
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(_finite(content), indent=2, allow_nan=False)
        (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
        (folder / f"{name}.md").write_text(page, encoding="utf-8")
        if table:
            with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows(table)


def markdown_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a table in Markdown."""
    return [f"| {' | '.join(row)} |" for row in (columns, ["---"] * len(columns), *rows)]


def provenance_line() -> str:
    """The sentence that names the versions a report was made with."""
    return "Made by " + ", ".join(f"{name} {version}" for name, version in provenance().items()) + "."


def _finite(content: Any) -> Any:
    if isinstance(content, dict):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content
