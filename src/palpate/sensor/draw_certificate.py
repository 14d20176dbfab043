"""Pages of a certificate: text, tables, signature fields and errors on A4."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from palpate.core import FloatArray
from palpate.core.report import Report
from palpate.sensor.report import provenance_line
from palpate.sensor.score import COMPONENTS

_A4 = (8.27, 11.69)
"""Size of a page, inches (ISO 216)."""
_LEFT, _LINE, _SIZE = 0.08, 0.0128, 8
"""Margin and line height over the page, and font size in points. By hand."""


class Page:
    """A page of A4, filled from above.

    Parameters
    ----------
    title
        Title of the page.
    """

    def __init__(self, title: str) -> None:
        self.figure = Figure(figsize=_A4)
        self.y = 1.0 - 0.5 * _LEFT
        self._write(title, weight="bold", size=1.6 * _SIZE)
        self.y -= 2.0 * _LINE

    def _write(self, text: str, x: float = _LEFT, *, weight: str = "normal", size: float = _SIZE) -> None:
        self.figure.text(x, self.y, text, va="top", fontsize=size, fontweight=weight)

    def _rule(self) -> None:
        self.figure.add_artist(Line2D([_LEFT, 1.0 - _LEFT], [self.y, self.y], color="0.6", linewidth=0.6))

    def heading(self, text: str) -> None:
        """Write a heading."""
        self.y -= 0.5 * _LINE
        self._write(text, weight="bold", size=1.2 * _SIZE)
        self.y -= 1.5 * _LINE

    def paragraph(self, text: str, *, bold: bool = False) -> None:
        """Write a paragraph, wrapped to the width of the page."""
        width = _characters(1.0 - (3.0 if bold else 2.0) * _LEFT)
        for line in textwrap.wrap(text, width):
            self._write(line, weight="bold" if bold else "normal")
            self.y -= _LINE
        self.y -= 0.2 * _LINE

    def table(self, table: Report, widths: Sequence[float]) -> None:
        """Write a table with columns of relative widths, whose cells are wrapped, and its notes."""
        shares = np.array(widths) / sum(widths) * (1.0 - 2.0 * _LEFT)
        starts = _LEFT + np.cumsum([0.0, *shares[:-1]])
        head = [column.label for column in table.columns]
        body = [[column.text(row.get(column.name)) for column in table.columns] for row in table.rows]
        for number, row in enumerate([head, *body]):
            cells = [textwrap.wrap(text, _characters(share)) for text, share in zip(row, shares, strict=True)]
            for x, cell in zip(starts, cells, strict=True):
                self._write("\n".join(cell), float(x), weight="normal" if number else "bold")
            self.y -= _LINE * max(len(cell) for cell in cells)
            if not number:
                self._rule()
                self.y -= 0.2 * _LINE
        self.y -= 0.5 * _LINE
        for note in table.notes:
            self.paragraph(note)

    def signatures(self, names: Sequence[str]) -> None:
        """Write lines to be filled in by hand, and the date of issue."""
        self.heading("Signatures")
        for name in names:
            self.y -= 0.5 * _LINE
            self._write(f"{name}:")
            self.y -= 1.2 * _LINE
            self._rule()
        self.y -= 0.5 * _LINE
        self.paragraph(f"Issued {datetime.now(UTC):%Y-%m-%d} (UTC). {provenance_line()}")


def _characters(share: float) -> int:
    """Return the number of characters that fit into a share of the page, at 0.55 em each."""
    return max(int(share * _A4[0] * 72.0 / (0.55 * _SIZE)), 1)


def draw_errors(page: Page, truth: FloatArray, errors: FloatArray) -> None:
    """Draw errors (n, 2 or 3) over known pose (n, 3) and depth, on the rest of a page."""
    rows = errors.shape[1]
    below = page.figure.add_gridspec(
        rows, 2, left=1.5 * _LEFT, right=1.0 - _LEFT, bottom=_LEFT, top=page.y - _LINE, hspace=1.0
    )
    for row, (name, unit) in enumerate(COMPONENTS[:rows]):
        for column, (place, label) in enumerate(((row, f"{name} ({unit})"), (2, "depth (mm)"))):
            axis = page.figure.add_subplot(below[row, column])
            axis.plot(truth[:, place], errors[:, row], ".", markersize=3, alpha=0.6)
            axis.axhline(0.0, color="0.6", linewidth=0.8)
            axis.set_xlabel(label, fontsize=_SIZE)
            axis.set_ylabel(f"error ({unit})", fontsize=_SIZE)
            axis.tick_params(labelsize=_SIZE)
            axis.spines[["top", "right"]].set_visible(False)


def save_pages(path: Path, pages: Sequence[Page]) -> None:
    """Number the pages and write them as PDF."""
    with PdfPages(path) as file:
        for number, page in enumerate(pages, start=1):
            footer = f"Page {number} of {len(pages)}"
            page.figure.text(1.0 - _LEFT, 0.5 * _LEFT, footer, ha="right", fontsize=_SIZE)
            file.savefig(page.figure)
