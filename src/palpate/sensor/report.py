"""Reports as files: a page in Markdown, strict JSON, CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from palpate.core import provenance, wrap_write_errors
from palpate.core.report import Report, json_text, page_markdown, write_csv

Rows = Sequence[Sequence[str]]


def write_report(folder: Path, name: str, content: Any, page: Iterable[str | Report], table: Rows = ()) -> None:
    """Write ``name.json``, ``name.md`` and, if there is a table, ``name.csv`` into a folder, which is made.

    Parameters
    ----------
    folder, name
        Folder, and beginning of the files' names.
    content
        JSON data; numbers that are not finite become null.
    page
        Paragraphs in Markdown, and tables.
    table
        Rows, the first of them the columns.

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
    """The sentence that names the versions a report was made with."""
    return "Made by " + ", ".join(f"{name} {version}" for name, version in provenance().items()) + "."
