"""A table of numbers in a text file that some bench wrote: preamble, header, units, rows."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.material.spec import DECIMALS, DELIMITERS, TestFileSpec

MOST_ROWS = 50_000
"""Rows beyond these are thinned evenly: no curve needs more."""
MOST_BYTES = 2_000_000_000
_HEAD = 400
"""Lines by which the dialect is found."""
_COMMENT = ("#", "//")
_BOMS = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))
_FOREIGN = re.compile(rb"[\x00-\x08\x0e-\x1a\x1c-\x1f]")
_SAVE = "Save the table as CSV text."

Line = tuple[int, str]
"""Number of a line in its file, from 1, and its text."""


@dataclass(frozen=True)
class Table:
    """Numbers of a file and what is written above them.

    Attributes
    ----------
    path
        The file.
    header
        Names of the columns; empty where the file has none.
    units
        Texts of a row of units below the header; empty where there is none.
    preamble
        Lines above the header, and the comments.
    values
        (n, columns); nan where a cell is empty.
    lines
        (n,) line of each row in the file, from 1.
    skipped
        Rows of the file that were thinned away.
    """

    path: Path
    header: tuple[str, ...]
    units: tuple[str, ...]
    preamble: tuple[str, ...]
    values: FloatArray
    lines: IntArray
    skipped: int


@dataclass(frozen=True)
class _Dialect:
    delimiter: str
    decimal: str

    def split(self, text: str) -> list[str]:
        """Cut a line into its cells, without the spaces and quotes around them."""
        if self.delimiter == " ":
            return text.split()
        if '"' in text:
            return [cell.strip() for cell in next(csv.reader([text], delimiter=self.delimiter))]
        return [cell.strip() for cell in text.split(self.delimiter)]

    def number(self, cell: str) -> float | None:
        """Value of a cell, nan where it is empty; none where it is no number."""
        if not cell:
            return float("nan")
        if self.decimal == "," and "." in cell:
            return None
        try:
            return float(cell.replace(",", ".") if self.decimal == "," else cell) if "_" not in cell else None
        except ValueError:
            return None

    def is_row(self, text: str) -> bool:
        """Whether a line is a row of at least two numbers."""
        cells = self.split(text)
        return sum(map(bool, cells)) >= 2 and all(self.number(cell) is not None for cell in cells)


def read_table(path: Path, spec: TestFileSpec) -> Table:
    """Read the numbers of a file.

    Parameters
    ----------
    path
        The file.
    spec
        Its delimiter and decimal mark are taken if given, found otherwise.

    Raises
    ------
    PalpateError
        If it is no text, holds no table, or a cell is no number; the message names row and column.
    """
    data = _read_bytes(path)
    lines, skipped = _lines(path, data)
    kept = [line for line in lines if line[1].strip() and not line[1].lstrip().startswith(_COMMENT)]
    if not kept:
        raise PalpateError(f"{path} is empty.", "Export the test again.", code="table-empty")
    dialect = _find_dialect(path, kept, spec)
    first = next(at for at, (_, text) in enumerate(kept) if dialect.is_row(text))
    width = len(_trimmed(dialect.split(kept[first][1])))
    comments = tuple(text for _, text in lines[:_HEAD] if text.lstrip().startswith(_COMMENT))
    header, units, above = _read_head(path, kept[:first], dialect, width, comments)
    width = max(width, len(header))
    values = _read_rows(path, kept[first:], dialect, header or ("",) * width)
    numbers = np.array([number for number, _ in kept[first:]], np.int64)
    return Table(path, header, units, (*above, *comments), values, numbers, skipped)


def _read_bytes(path: Path) -> bytes:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise PalpateError(
                f"{path} has {path.stat().st_size / 1e9:.1f} GB.", "Export fewer rows.", code="table-too-large"
            )
        data = path.read_bytes()
    except OSError as error:
        raise PalpateError(
            f"{path} cannot be read: {error.strerror}.", "Give the CSV files of a test.", code="file-unreadable"
        ) from None
    if data.startswith(b"PK") or data.startswith(b"\xd0\xcf\x11\xe0"):
        raise PalpateError(f"{path} is a spreadsheet or an archive, not text.", _SAVE, code="file-is-spreadsheet")
    for mark, encoding in _BOMS:
        if data.startswith(mark):
            return data[len(mark) :].decode(encoding, "replace").encode() if encoding != "utf-8" else data[3:]
    if _FOREIGN.search(data[:100_000]):
        raise PalpateError(f"{path} is not text: it holds binary data.", _SAVE, code="file-not-text")
    return data


def _lines(path: Path, data: bytes) -> tuple[list[Line], int]:
    """Lines of a file with their numbers; of a very long one, the head and every k-th of the rest."""
    if b"\n" not in data:
        data = data.replace(b"\r", b"\n")
    count = data.count(b"\n") + 1
    if count <= MOST_ROWS:
        return list(enumerate(_decode(data).splitlines(), start=1)), 0
    end = np.flatnonzero(np.frombuffer(data, np.uint8) == ord("\n"))
    step = -(-len(end) // MOST_ROWS)
    chosen = np.concatenate([np.arange(_HEAD), np.arange(_HEAD, len(end) - 1, step)])
    begin = np.concatenate([[0], end[:-1] + 1])
    lines = [(int(at) + 1, _decode(data[begin[at] : end[at]]).rstrip("\r")) for at in chosen]
    return lines, len(end) - len(chosen)


def _decode(data: bytes) -> str:
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _find_dialect(path: Path, lines: list[Line], spec: TestFileSpec) -> _Dialect:
    """The delimiter and decimal mark by which most lines are rows of numbers."""
    delimiters = [DELIMITERS[spec.delimiter]] if spec.delimiter else ["\t", ";", ",", " "]
    decimals = [DECIMALS[spec.decimal]] if spec.decimal else [".", ","]
    found = [_Dialect(delimiter, decimal) for delimiter in delimiters for decimal in decimals if delimiter != decimal]
    head = [text for _, text in lines[:_HEAD]]
    scores = [sum(map(dialect.is_row, head)) for dialect in found]
    if not found or not max(scores):
        number, text = next(((n, t) for n, t in lines if any(c.isdigit() for c in t)), lines[0])
        raise PalpateError(
            f"{path}: no row holds two numbers side by side (row {number} is '{text.strip()[:40]}').",
            "Columns stand apart by comma, semicolon, tab or space; --delimiter and --decimal say which.",
            code="table-no-numbers",
        )
    return found[int(np.argmax(scores))]


def _read_head(
    path: Path, lines: list[Line], dialect: _Dialect, width: int, comments: tuple[str, ...]
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Header, units and preamble from the lines above the first row of numbers."""
    texts = [text for _, text in lines]
    if not lines:
        if comments and len(cells := _trimmed(dialect.split(comments[-1].lstrip("#/ ")))) == width:
            return tuple(cells), (), ()
        return (), (), ()
    last = _trimmed(dialect.split(texts[-1]))
    words = [cell for cell in last if cell and dialect.number(cell) is None]
    if words and len(words) < sum(map(bool, last)):
        raise PalpateError(
            f"{path}: row {lines[-1][0]}, column {last.index(words[0]) + 1}: '{words[0][:40]}' is no number.",
            "Mend or delete the row, or put # in front of it.",
            code="value-not-number",
        )
    if not words:
        return (), (), tuple(texts)
    above = _trimmed(dialect.split(texts[-2])) if len(texts) > 1 else []
    if len(above) == len(last) > 1 and all(map(_is_unit, last)):
        header, units, rest = above, last, texts[:-2]
    else:
        header, units, rest = last, [], texts[:-1]
    if len(header) < 2:
        return (), (), tuple(texts)
    if len(header) != width:
        raise PalpateError(
            f"{path}: row {lines[-1][0]} names {len(header)} columns, but row {lines[-1][0] + 1} has {width} cells.",
            "Name every column once; a decimal comma needs another delimiter, and a name holds no delimiter.",
            code="header-length-wrong",
        )
    return tuple(header), tuple(units), tuple(rest)


def _is_unit(cell: str) -> bool:
    text = cell.strip("()[]{} ")
    return len(text) <= 6 and bool(re.fullmatch(r"[A-Za-zµ%°/²0-9^\-]*", text)) and not text.isdigit()


def _trimmed(cells: list[str]) -> list[str]:
    """Cells without the empty ones at the end."""
    count = max((at + 1 for at, cell in enumerate(cells) if cell), default=0)
    return cells[:count]


def _read_rows(path: Path, lines: list[Line], dialect: _Dialect, names: tuple[str, ...]) -> FloatArray:
    values = np.full((len(lines), len(names)), np.nan)
    for at, (number, text) in enumerate(lines):
        cells = _trimmed(dialect.split(text))
        if len(cells) > len(names):
            raise PalpateError(
                f"{path}: row {number} has {len(cells)} cells where {len(names)} are usual.",
                "Mend the row; a decimal comma needs another delimiter.",
                code="row-length-wrong",
            )
        for column, cell in enumerate(cells):
            value = dialect.number(cell)
            if value is None or (cell and not np.isfinite(value)):
                label = f"column {column + 1}" + (f" ({names[column]})" if names[column] else "")
                raise PalpateError(
                    f"{path}: row {number}, {label}: '{cell[:40]}' is no number.",
                    _mend(cell, dialect),
                    code="value-not-number",
                )
            values[at, column] = value
    return values


def _mend(cell: str, dialect: _Dialect) -> str:
    if re.fullmatch(r"[-+]?[\d.,]+(?:[eE][-+]?\d+)?", cell):
        mark = "comma" if dialect.decimal == "," else "point"
        return f"The decimal mark of this file is the {mark}: write one mark throughout, and none for thousands."
    if re.match(r"[-+]?[\d.,]+\s*[A-Za-z%]", cell):
        return "Write numbers only, and the unit in the header."
    return "Mend or delete the row, or put # in front of it."
