"""Tables of results: one type, written as text for a terminal of any width, as Markdown, HTML and CSV."""

from __future__ import annotations

import csv
import html
import io
import json
import math
import re
import textwrap
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TextIO

from palpate.core.files import atomic_write

Value = object
"""Entry of a table: a number, a text, a truth value, or `None` if it is missing."""

UNITS = {"mm": "mm", "deg": "°", "mpa": "MPa", "kpa": "kPa", "n": "N", "px": "px", "s": "s", "ms": "ms", "mj": "mJ"}
"""Last part of a column's name → its unit."""
EMPTY = "–"
GAP = 2
"""Spaces between the columns of a text."""
_NUMBER = re.compile(r"[-+±<>≤≥]? ?(\d[\d.]*|∞)(e[-+]?\d+)?( ?%)?")
PROSE = 24
"""Minimum width of a column of sentences, in characters."""


@dataclass(frozen=True)
class Column:
    """One column of a report.

    Attributes
    ----------
    name
        Key of the column in a row, in JSON and in CSV.
    heading
        Heading of the column; the name without its unit if empty.
    unit
        Unit; read from the last part of the name if `None`.
    form
        Format of a number, e.g. ``".3f"``; three decimals, or none for whole numbers, if empty.
    meaning
        One line of the legend; no line if empty.
    deciding
        Whether the column stays in a narrow terminal, which leaves out columns that are not deciding.
    prose
        Whether its texts are sentences, which may be wrapped. Numbers and names never do.
    """

    name: str
    heading: str = ""
    unit: str | None = None
    form: str = ""
    meaning: str = ""
    deciding: bool = True
    prose: bool = False

    @property
    def title(self) -> str:
        """Heading without the unit."""
        words, _, last = self.name.rpartition("_")
        named = words if self.unit is None and last in UNITS and words else self.name
        return self.heading or named.replace("_", " ").replace("rmse", "RMSE")

    @property
    def measure(self) -> str:
        """Unit; empty for a number without dimension."""
        words, _, last = self.name.rpartition("_")
        return self.unit if self.unit is not None else UNITS.get(last, "") if words else ""

    @property
    def label(self) -> str:
        """Heading with the unit, e.g. ``"travel (mm)"``."""
        return f"{self.title} ({self.measure})" if self.measure else self.title

    def text(self, value: Value) -> str:
        """Return a value of this column as text."""
        if value is None or value == "":
            return EMPTY
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, int | float):
            if not math.isfinite(value):
                return EMPTY if math.isnan(value) else "∞" if value > 0 else "-∞"
            whole = float(value).is_integer() and not self.form
            return format(value, self.form or (".12g" if whole else ".3f"))
        if isinstance(value, list | tuple):
            return ", ".join(self.text(each) for each in value) or EMPTY
        return str(value)


@dataclass(frozen=True)
class Report:
    """A table of results.

    Attributes
    ----------
    title
        Title of the table; none if empty.
    columns
        The columns in their order.
    rows
        One mapping a row, from the name of a column to its value. A name that is missing has no value.
    notes
        Sentences below the table.
    file
        File that has all columns, e.g. ``"results/first/grid.csv"``.
    """

    title: str
    columns: Sequence[Column]
    rows: Sequence[Mapping[str, Value]]
    notes: Sequence[str] = field(default=())
    file: str = ""

    @classmethod
    def of(
        cls,
        title: str,
        headings: Sequence[str | Column],
        rows: Iterable[Sequence[Value]],
        *notes: str,
        details: Container[str] = (),
    ) -> Report:
        """Build a table from rows whose values are in the order of the columns.

        A text among `headings` is the heading of its column, which is not deciding if it is among `details`.
        """
        columns = [
            Column(f"{number} {one}", one, "", deciding=one not in details) if isinstance(one, str) else one
            for number, one in enumerate(headings)
        ]
        names = [one.name for one in columns]
        return cls(title, columns, [dict(zip(names, row, strict=True)) for row in rows], notes)


def report_text(report: Report, width: int | None = None, *, wide: bool = False) -> str:
    """Return a report as text that cuts no number and no name; a column without any value is left out.

    Parameters
    ----------
    report
        The report.
    width
        Columns of the terminal; `None` if lines may be of any length. Columns that do not fit are left out and
        counted below the table, those that are not deciding first. If the deciding ones do not fit, every row
        becomes a block with a line for each column.
    wide
        Whether all columns are written, with their legend, as blocks if they do not fit.

    Returns
    -------
    str
        Lines of at most `width` characters, without spaces at their ends. Only a word that is longer is written
        beyond it.
    """
    columns = [one for one in report.columns if set(_texts(report, one)) - {EMPTY}]
    shown = columns if wide or width is None else _fitting(report, columns, width)
    lines = wrapped(report.title, width) if report.title else []
    if not shown:
        lines += [] if report.rows else ["No rows."]
    elif width is None or _table_width(report, shown) <= width:
        lines += _table(report, shown, width)
    else:
        lines += _blocks(report, shown, width)
    hidden = len(columns) - len(shown)
    if hidden:
        elsewhere = ["--wide", "--json", *([report.file] if report.file else [])]
        more = f"{hidden} more column{'s' if hidden > 1 else ''}: "
        lines += wrapped(f"{more}{', '.join(elsewhere)}", width)
    if wide:
        for one in shown:
            lines += wrapped(f"{one.title}: {one.meaning}", width, "  ") if one.meaning else []
    for note in report.notes:
        lines += wrapped(note, width)
    return "\n".join(line.rstrip() for line in lines)


def report_markdown(report: Report) -> str:
    """Return the table of a report in Markdown, numbers to the right, without its title and notes."""
    numbers = [_is_numeric(report, one) for one in report.columns]
    rows = [[_markdown(one.text(row.get(one.name))) for one in report.columns] for row in report.rows]
    rules = ["---:" if numeric else ":---" for numeric in numbers]
    lines = [[_markdown(one.label) for one in report.columns], rules, *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def page_markdown(parts: Iterable[str | Report]) -> str:
    """Return a page of paragraphs in Markdown and of tables; empty paragraphs are left out."""
    texts = (part if isinstance(part, str) else report_markdown(part).rstrip() for part in parts)
    return "\n\n".join(text for text in texts if text) + "\n"


def plain_page(parts: Iterable[str | Report]) -> Iterator[str | Report]:
    """Yield the parts of a page for a terminal: without marks of headings and emphasis, and images."""
    texts: list[str] = []
    for part in (*parts, None):
        if isinstance(part, str):
            texts += [re.sub(r"^#+ |\*\*", "", part)] if part and not part.startswith("![") else []
            continue
        if texts:
            yield "\n\n".join(texts)
        texts = []
        if part is not None:
            yield part


def report_html(report: Report) -> str:
    """Return the table of a report in HTML, its texts escaped."""
    head = "".join(f"<th>{html.escape(one.label)}</th>" for one in report.columns)
    rows = [
        "".join(f"<td>{html.escape(one.text(row.get(one.name)))}</td>" for one in report.columns)
        for row in report.rows
    ]
    return f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"


class CsvWriter:
    """CSV (RFC 4180, lines end in ``\\n``), written row by row to a file opened with ``newline=""``."""

    def __init__(self, file: TextIO, columns: Sequence[str]) -> None:
        self._columns = columns
        self._writer = csv.writer(file, lineterminator="\n")
        self._writer.writerow(columns)

    def write(self, row: Mapping[str, Value] | Sequence[Value]) -> None:
        """Write one row: its values by column, or in the order of the columns. `None` becomes empty."""
        self._writer.writerow([row.get(name) for name in self._columns] if isinstance(row, Mapping) else row)


def json_text(content: object) -> str:
    """Return data as strict JSON; numbers that are not finite become null."""
    return json.dumps(_finite(content), indent=2, allow_nan=False)


def csv_text(rows: Iterable[Mapping[str, Value]]) -> str:
    """Return rows as CSV with the columns of the first; an empty text without rows."""
    listed, text = list(rows), io.StringIO()
    if listed:
        _write_csv(text, listed, list(listed[0]))
    return text.getvalue()


def write_csv(path: Path, rows: Iterable[Mapping[str, Value] | Sequence[Value]], columns: Sequence[str]) -> None:
    """Write a CSV file, replacing it; its rows may come one by one.

    A row has values by column, or in the order of the columns.

    Raises
    ------
    PalpateError
        If the file cannot be written.
    """
    with atomic_write(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        _write_csv(file, rows, columns)


def _finite(content: object) -> object:
    if isinstance(content, dict):
        return {str(key): _finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    return None if isinstance(content, float) and not math.isfinite(content) else content


def _write_csv(file: TextIO, rows: Iterable[Mapping[str, Value] | Sequence[Value]], columns: Sequence[str]) -> None:
    table = CsvWriter(file, columns)
    for row in rows:
        table.write(row)


def _markdown(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _texts(report: Report, column: Column) -> list[str]:
    return [column.text(row.get(column.name)) for row in report.rows]


def _is_numeric(report: Report, column: Column) -> bool:
    known = set(_texts(report, column)) - {EMPTY}
    return bool(known) and all(map(_NUMBER.fullmatch, known))


def _column_width(report: Report, column: Column) -> int:
    """Return the minimum width that cuts no number, name or word."""
    cells = _texts(report, column)
    longest = max(map(len, cells), default=0)
    if column.prose and longest > PROSE:
        longest = max(PROSE, *(len(word) for cell in cells for word in cell.split()))
    return max([longest, *map(len, _heading(column, 1)), len(column.measure)])


def _heading(column: Column, width: int) -> list[str]:
    """Lines of a heading, which may end at spaces and behind hyphens."""
    return textwrap.wrap(column.title, width, break_long_words=False)


def _table_width(report: Report, columns: Sequence[Column]) -> int:
    return sum(_column_width(report, one) + GAP for one in columns) - GAP


def _fitting(report: Report, columns: Sequence[Column], width: int) -> list[Column]:
    """Return the deciding columns, and further columns in their order while they fit."""
    chosen = [one for one in columns if one.deciding]
    for one in columns:
        if one not in chosen and _table_width(report, [*chosen, one]) <= width:
            chosen.append(one)
    return [one for one in columns if one in chosen]


def _table(report: Report, columns: Sequence[Column], width: int | None) -> list[str]:
    """Lines of a table, its headings in as many lines as they need, units in the line above the rule."""
    widths = [_column_width(report, one) for one in columns]
    right = [_is_numeric(report, one) for one in columns]
    texts = [_texts(report, one) for one in columns]
    prose = [number for number, one in enumerate(columns) if one.prose]
    free = 10_000 if width is None else width - _table_width(report, columns)
    for number in prose:
        widths[number] = max(widths[number], min(max(map(len, texts[number])), widths[number] + free // len(prose)))
    heads = [_heading(one, size) for one, size in zip(columns, widths, strict=True)]
    tall = max(map(len, heads))
    heads = [[""] * (tall - len(lines)) + lines for lines in heads]
    if any(one.measure for one in columns):
        heads = [[*lines, one.measure] for one, lines in zip(columns, heads, strict=True)]
    lines = [*_aligned(heads, widths, right), (" " * GAP).join("─" * size for size in widths)]
    for row in zip(*texts, strict=True):
        cells = zip(columns, row, widths, strict=True)
        lines += _aligned([wrapped(cell, size) if one.prose else [cell] for one, cell, size in cells], widths, right)
    return lines


def _aligned(cells: Sequence[Sequence[str]], widths: Sequence[int], right: Sequence[bool]) -> list[str]:
    """Lines of cells that have some lines each."""
    tall = max(map(len, cells))
    padded = [[*lines, *[""] * (tall - len(lines))] for lines in cells]
    return [
        (" " * GAP).join(
            line.rjust(size) if numeric else line.ljust(size)
            for line, size, numeric in zip(parts, widths, right, strict=True)
        )
        for parts in zip(*padded, strict=True)
    ]


def _blocks(report: Report, columns: Sequence[Column], width: int) -> list[str]:
    """A block of lines for each row: heading, value and unit."""
    room = min(max(len(one.title) for one in columns), max(2 * width // 3 - 4, 0))
    lines: list[str] = []
    for row in report.rows:
        for number, one in enumerate(columns):
            value = one.text(row.get(one.name))
            unit = f" {one.measure}" if one.measure and value != EMPTY else ""
            title = f"{'  ' if number else ''}{one.title}".ljust(room + 2)
            lines += wrapped(f"{title}  {value}{unit}", width, " " * (room + 4))
    return lines


def wrapped(text: str, width: int | None, indent: str = "") -> list[str]:
    """Return the lines of a text of at most `width` characters; a longer word stays whole.

    The text's own line ends stay; the second and later lines begin with `indent`.
    """
    if width is None:
        return text.split("\n")
    wrapper = textwrap.TextWrapper(width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return [line for one in text.split("\n") for line in wrapper.wrap(one) or [""]]
