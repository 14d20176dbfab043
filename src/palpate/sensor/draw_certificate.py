"""Pages of a report and its errors as PDF on A4."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from palpate.core import FloatArray
from palpate.core.report import Report
from palpate.sensor.score import COMPONENTS

_A4 = (8.27, 11.69)
"""Size of a page, inches (ISO 216)."""
_LEFT, _LINE, _SIZE = 0.08, 0.0128, 8
"""Margin and line height over the page, and font size in points."""


def write_pages(path: Path, page: Iterable[str | Report], truth: FloatArray, errors: FloatArray) -> None:
    """Write paragraphs in Markdown and tables, then errors (n, 2 or 3) over known poses (n, 3), as PDF."""
    pages, y = [Figure(figsize=_A4)], 1.0 - 0.5 * _LEFT

    def put(texts: Iterable[tuple[float, str]], lines: int, size: float = 1.0, weight: str = "normal") -> None:
        nonlocal y
        if y - lines * _LINE < _LEFT:
            pages.append(Figure(figsize=_A4))
            y = 1.0 - 0.5 * _LEFT
        for x, text in texts:
            pages[-1].text(_LEFT + x, y, text, va="top", fontsize=size * _SIZE, fontweight=weight)
        y -= lines * size * _LINE

    width = 1.0 - 2.0 * _LEFT
    for item in page:
        if isinstance(item, Report):
            rows = [[column.label for column in item.columns]]
            rows += [[column.text(row.get(column.name)) for column in item.columns] for row in item.rows]
            sizes = np.array([max(map(len, column)) for column in zip(*rows, strict=True)]) + 2.0
            shares = width * sizes / sizes.sum()
            starts = np.cumsum([0.0, *shares[:-1]]).tolist()
            if y - 1.2 * len(rows) * _LINE < _LEFT:
                y = 0.0
            for number, row in enumerate(rows):
                cells = [_wrap(text, share) for text, share in zip(row, shares, strict=True)]
                texts = zip(starts, map("\n".join, cells), strict=True)
                put(texts, max(map(len, cells)), weight="normal" if number else "bold")
            y -= 0.5 * _LINE
            item = "\n".join(item.notes)
        mark = item[: len(item) - len(item.lstrip("#"))]
        plain, heading = item.lstrip("# ").replace("**", ""), bool(mark) or item.startswith("**")
        y = y - 0.5 * _LINE * len(mark) if y > 2.0 * _LEFT or not mark else 0.0
        for part in plain.splitlines():
            for line in _wrap(part, width - _LEFT * heading):
                put([(0.0, line)], 1, 1.6 if mark == "#" else 1.2 if mark else 1.0, "bold" if heading else "normal")
        y -= 0.3 * _LINE
    if y < 3.0 * _LEFT:
        pages.append(Figure(figsize=_A4))
        y = 1.0 - 0.5 * _LEFT
    _draw_errors(pages[-1], y, truth, errors)
    with PdfPages(path) as file:
        for number, figure in enumerate(pages, start=1):
            footer = f"Page {number} of {len(pages)}"
            figure.text(1.0 - _LEFT, 0.5 * _LEFT, footer, ha="right", fontsize=_SIZE)
            file.savefig(figure)


def _wrap(text: str, share: float) -> list[str]:
    """Wrap a text to a share of the page, at 0.55 em for a character."""
    return textwrap.wrap(text, max(int(share * _A4[0] * 72.0 / (0.55 * _SIZE)), 1)) or [""]


def _draw_errors(figure: Figure, top: float, truth: FloatArray, errors: FloatArray) -> None:
    rows = errors.shape[1]
    places = {"left": 1.5 * _LEFT, "right": 1 - _LEFT, "bottom": _LEFT, "top": top - _LINE}
    below = figure.add_gridspec(rows, 2, hspace=0.5, wspace=0.3, **places)
    for row, (name, unit) in enumerate(COMPONENTS[:rows]):
        for column, (place, label) in enumerate(((row, f"{name} ({unit})"), (2, "depth (mm)"))):
            axis = figure.add_subplot(below[row, column])
            axis.plot(truth[:, place], errors[:, row], ".", markersize=3, alpha=0.6)
            axis.axhline(0.0, color="0.6", linewidth=0.8)
            axis.set_xlabel(label, fontsize=_SIZE)
            axis.set_ylabel(f"error ({unit})", fontsize=_SIZE)
            axis.tick_params(labelsize=_SIZE)
            axis.spines[["top", "right"]].set_visible(False)
