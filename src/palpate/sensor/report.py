"""Report files: a page in Markdown, strict JSON, CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from palpate.core import provenance, wrap_write_errors
from palpate.core.report import Report, json_text, page_markdown, write_csv

Rows = Sequence[Sequence[str]]


def write_report(folder: Path, name: str, content: Any, page: Iterable[str | Report], table: Rows = ()) -> None:
    """Write ``name.json``, ``name.md`` and, with a table, ``name.csv`` into a folder, which is created.

    `content` is JSON data, in which numbers that are not finite become null; `page` has paragraphs in Markdown, and
    tables; the first row of `table` holds the columns.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    with wrap_write_errors(folder, "Choose another folder."):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.json").write_text(json_text(content) + "\n", encoding="utf-8")
        (folder / f"{name}.md").write_text(page_markdown(page), encoding="utf-8")
        if table:
            write_csv(folder / f"{name}.csv", table[1:], table[0])


def provenance_line() -> str:
    """Return a sentence with the versions that made a report."""
    return "Made by " + ", ".join(f"{name} {version}" for name, version in provenance().items()) + "."
