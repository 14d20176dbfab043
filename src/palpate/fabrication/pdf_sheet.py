"""Workshop sheet as PDF on A4: text, table, drawings and artwork, with numbered pages."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from palpate.core.report import Report
from palpate.fabrication.drawing_sheet import MM_PER_INCH, PAGE, TitleBlock
from palpate.fabrication.instructions import Section

_LINES, _WIDTH = 56, 92
"""Lines of a page of text and characters of a line."""
_CELLS = (4, 18, 11, 48, 28, 24)
"""Characters of the columns of a table."""


def write_sheet(path: Path, sections: Sequence[Section], drawings: Sequence[Figure], block: TitleBlock) -> None:
    """Write text, tables and drawings (with their title blocks), and number all pages."""
    lines = [line for section in sections if section.lines for line in _lay_out(section)]
    texts = [_page(lines[start : start + _LINES]) for start in range(0, len(lines), _LINES)]
    for section in sections:
        texts += _table_pages(section.title, section.table) if section.table else []
    for figure in texts:
        block.head(figure)
    figures = [*texts, *drawings]
    with PdfPages(path, metadata={"CreationDate": None}) as pages:
        for number, figure in enumerate(figures, start=1):
            block.number(figure, number, len(figures))
            pages.savefig(figure)


def _table_pages(title: str, table: Report) -> list[Figure]:
    """Draw the rows of a table, with the texts of its columns wrapped, on as many pages as they need."""
    rows = [[column.label for column in table.columns]]
    rows += [[column.text(row.get(column.name)) for column in table.columns] for row in table.rows]
    pages: list[Figure] = []
    used = float(_LINES)
    for k, row in enumerate(rows):
        cells = [textwrap.wrap(text, wide) for text, wide in zip(row, _CELLS, strict=True)]
        tall = max(len(cell) for cell in cells) + 0.4
        if used + tall > _LINES:
            pages.append(_page([(title, True)]))
            used = 2.0
        for cell, indent in zip(cells, np.cumsum([0, *_CELLS]), strict=False):
            x, y, weight = 0.071 + 0.0064 * indent, 0.955 - 0.0155 * used, "normal" if k else "bold"
            pages[-1].text(x, y, "\n".join(cell), fontsize=6.5, fontweight=weight, va="top", linespacing=1.35)
        used += 0.72 * tall
    return pages


def _lay_out(section: Section) -> list[tuple[str, bool]]:
    """Return the lines of a section, and whether each is a heading."""
    lines = [(section.title, True)]
    for k, line in enumerate(section.lines, start=1):
        mark = f"{k}. " if section.steps else "·  "
        wrapped = textwrap.wrap(line, _WIDTH, initial_indent=mark, subsequent_indent="   ")
        lines += [(part, False) for part in wrapped]
    return [*lines, ("", False)]


def _page(lines: Sequence[tuple[str, bool]]) -> Figure:
    figure = Figure(figsize=(PAGE[0] / MM_PER_INCH, PAGE[1] / MM_PER_INCH))
    for k, (line, heading) in enumerate(lines):
        size, weight = (11, "bold") if heading else (9, "normal")
        figure.text(0.09, 0.955 - k * 0.0155, line, fontsize=size, fontweight=weight, va="top")
    return figure
