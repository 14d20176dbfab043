"""Structure of a table in text: dialect, blocks of rows, headings and units."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from palpate.core.errors import PalpateError
from palpate.core.text_lines import HEAD, Line
from palpate.core.units import is_unit, split_unit

COMMENTS = ("#", "//")
_DELIMITERS = ("\t", ";", ",", "|", " ")
_NUMBERS_WITHIN = re.compile(r"[-+\d.,][;,|\t ]+[-+\d.,]|[\d.][;,|\t]$|^\d+[.,]\d+(?:[.,]\d+)?$")
"""Cells that a wrong delimiter or decimal mark leaves behind."""
_MIN_ROWS = 5
"""Fewer rows after the table may be a footer. By hand."""
_SUMMARY = re.compile(
    r"mean|average|median|st(?:andar)?d\.? ?dev(?:iation)?\.?|max(?:imum)?|min(?:imum)?|mittelwert|std\.?-?abw\.?"
    r"|standardabweichung|moyenne|[ée]cart[ -]type|平均值?|最大值?|最小值?|标准差|標準偏差",
    re.I,
)
"""First cells of the rows of statistics below a table, in a column of numbers."""
_CELLS = 4096
"""Number of cells whose kind is remembered: every dialect looks at the first lines several times."""
_TRUTH_VALUES = {"true": 1.0, "false": 0.0}
"""Words that are read as numbers."""
_THOUSANDS = {
    decimal: re.compile(rf"[-+]?\d{{1,3}}(?:(?:{mark}\d{{3}})+{point}\d+|(?:[\xa0\u202f'’]\d{{3}})+(?:{point}\d+)?)")
    for decimal, mark, point in ((".", ",", r"\."), (",", r"\.", ","))
}
"""Decimal mark → numbers with marks between the thousands that cannot be decimal marks."""
_FORTRAN = re.compile(r"[-+]?(?:\d+\.\d*|\.\d+)[dD](?:[-+]\d+|\d\d)")
_QUANTITY = re.compile(r"([-+\u2212]?[\d.,]*\d[\d.,]*(?:[eE][-+]?\d+)?)\s?([^\d\s.,].*)")
_TOKEN = re.compile(r"\S+(?:\s+[\[(][^\[\]()]*[\])])?")
"""Name of a column between spaces, with a unit in brackets behind it."""


def parse_number(cell: str, decimal: str = ".") -> float:
    """Value of a cell; NaN if it is empty or no number."""
    if decimal == "." or "." not in cell:
        try:
            return float(cell.replace(decimal, ".")) if "_" not in cell else float("nan")
        except ValueError:
            pass
    if cell[:1] == "\u2212":
        return parse_number("-" + cell[1:], decimal)
    if _THOUSANDS[decimal].fullmatch(cell):
        return float(re.sub(r"[^-+\d,.]" + ("|," if decimal == "." else r"|\."), "", cell).replace(",", "."))
    if _FORTRAN.fullmatch(cell):
        return parse_number(re.sub("[dD]", "e", cell), decimal)
    return _TRUTH_VALUES.get(cell.lower(), float("nan"))


@lru_cache(_CELLS)
def split_quantity(cell: str) -> tuple[str, str]:
    """Number and unit of a cell such as ``12.5 N`` or ``3%``; an empty unit without one.

    A letter directly behind a number, as in ``1A``, is no unit, but part of a name.
    """
    found = _QUANTITY.fullmatch(cell)
    if not found or not is_unit(found[2]) or found[2] in ("-", "–", "1"):
        return cell, ""
    named = len(found[2]) == 1 and found[2].isascii() and found[2].isalpha() and not cell[-2].isspace()
    return (cell, "") if named else (found[1], found[2])


@lru_cache(_CELLS)
def _is_number(cell: str, decimal: str) -> bool:
    return math.isfinite(parse_number(cell, decimal)) or cell.lower() in ("nan", "inf", "-inf")


@dataclass(frozen=True)
class Dialect:
    """Delimiter of cells and decimal mark of numbers."""

    delimiter: str
    decimal: str

    def split(self, text: str) -> list[str]:
        """Cells of a line, without the spaces and quotes around them."""
        if '"' in text:
            text = re.sub(rf'(^|{re.escape(self.delimiter)})="', r'\1"', text)  # a text of a spreadsheet
            if self.delimiter == " ":
                text = " ".join(text.split())
            try:
                rows = csv.reader([text], delimiter=self.delimiter, skipinitialspace=True)
                return [cell.strip() for cell in next(rows)]
            except (csv.Error, StopIteration):
                text = text.replace('"', "")
        if self.delimiter == " ":
            return _TOKEN.findall(text) if re.search(r"[\[(]", text) and text[:1].isalpha() else text.split()
        if "]" in text:  # a list is one cell: 7; p[0.4, -0.1, 0.2]
            return [cell.strip() for cell in re.split(rf"{re.escape(self.delimiter)}(?![^\[\]]*\])", text)]
        return [cell.strip() for cell in text.split(self.delimiter)]

    def is_number(self, cell: str) -> bool:
        """Whether a cell is a number."""
        return _is_number(cell, self.decimal)

    def count_numbers(self, cells: list[str]) -> int:
        """Numbers of a row: plain ones, or else numbers with their units if all cells are such."""
        return sum(self.is_number(cell) for cell in cells if cell) or self.count_quantities(cells)

    def count_quantities(self, cells: list[str]) -> int:
        """Cells of a row if all are numbers with units, otherwise 0."""
        bare = [split_quantity(cell)[0] for cell in cells if cell]
        return len(bare) if all(map(self.is_number, bare)) else 0

    def fit(self, text: str) -> int:
        """Numbers of a line, less the cells that are numbers only by another dialect; 0 if it is no row."""
        cells = self.split(text)
        numbers = self.count_numbers(cells)
        texts = (c for c in cells if c and not self.is_number(c) and not self.is_number(split_quantity(c)[0]))
        bad = sum(bool(_NUMBERS_WITHIN.search(c)) for c in texts)
        return numbers - 3 * bad if len(cells) >= 2 and numbers else -3 * bad


@dataclass
class Block:
    """Consecutive rows under one heading.

    Attributes
    ----------
    heading
        Places of the lines above the rows that hold no number.
    rows
        Places of the rows.
    header, units
        Names of the columns, and a row of units; empty if they are not written.
    width
        Cells of the rows, if there is no header.
    """

    heading: list[int]
    rows: list[int]
    header: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    width: int = 0


class Head(NamedTuple):
    """Names and units of the columns, and the lines above them."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    above: tuple[str, ...]


def find_dialect(path: Path, lines: list[Line], delimiter: str | None, decimal: str | None) -> Dialect:
    """Dialect by which most cells are numbers and no text is left that another dialect would split.

    Raises
    ------
    PalpateError
        If no line has two cells and a number.
    """
    filled = [text for _, text in lines if text.strip()]
    head = filled[:HEAD] + filled[-HEAD // 4 :] if len(filled) > HEAD else filled
    decimals = (decimal,) if decimal else (".", ",")
    marks = (delimiter,) if delimiter else _DELIMITERS
    found = [Dialect(mark, point) for mark in marks for point in decimals if mark != point]
    if any('"' in text for text in head):
        found += [Dialect(",", ",")] if (delimiter or ",") == "," and "," in decimals else []
    scores = [sum(dialect.fit(text) for text in head) for dialect in found]
    rows = [
        sum(1 for text in head if len(cells := dialect.split(text)) >= 2 and dialect.count_numbers(cells))
        for dialect in found
    ]
    chosen = max(range(len(found)), key=lambda at: (rows[at] > 0, scores[at]), default=None)
    if chosen is None or not rows[chosen]:
        header = Counter({mark: filled[0].count(mark) for mark in marks}).most_common(1)[0]
        if header[1] and header[0] != " " and all(header[0] in text for text in filled):
            return Dialect(header[0], decimal or ".")
        number, text = next(((n, t) for n, t in lines if any(c.isdigit() for c in t)), lines[0])
        raise PalpateError(
            f"{path}: no row holds two cells and a number (row {number} is '{text.strip()[:40]}').",
            "Separate columns by comma, semicolon, tab or space, and write numbers with one decimal mark.",
            code="table-no-numbers",
        )
    return found[chosen]


def find_blocks(lines: list[Line], dialect: Dialect) -> list[Block]:
    """Divide the lines of a file into headings and rows."""
    kinds: list[int] = []  # 0 blank, 1 row, 2 text, 3 quantities alone
    widths: list[int] = []
    for _, text in lines:
        cells = dialect.split(text) if text.strip() else []
        filled = list(filter(None, cells))
        number = len(cells) >= 2 and any(map(dialect.is_number, filled))
        quantities = len(cells) >= 2 and not number and dialect.count_quantities(cells)
        kinds.append(0 if not filled else 1 if number else 3 if quantities else 2)
        widths.append(len(filled))
    apart = 1 if kinds.count(3) > kinds.count(1) else 2  # a few lines of quantities are headings
    if 3 in kinds:
        kinds = [apart if kind == 3 else kind for kind in kinds]
    blocks, at, blank = [Block([], [])], 0, False
    while at < len(lines):
        if kinds[at] == 0:
            blank, at = True, at + 1
            continue
        block = blocks[-1]
        if kinds[at] == 1:
            if blank and block.rows:
                block = Block([], [])
                blocks.append(block)
            block.rows.append(at)
            blank, at = False, at + 1
            continue
        end, run = at, []
        while end < len(lines) and kinds[end] != 1:
            run += [end] if kinds[end] else []
            end += 1
        if not block.rows:
            block.heading += run
        elif _is_heading(lines, dialect, (block, run, blank), (widths, end)):
            blocks.append(Block(run, []))
        else:
            block.rows += run
        blank, at = False, end
    return _finish(lines, dialect, blocks, widths)


def _is_heading(
    lines: list[Line], dialect: Dialect, found: tuple[Block, list[int], bool], ahead: tuple[list[int], int]
) -> bool:
    """Whether lines without a number between rows are a heading of other rows, not faulty rows."""
    (block, run, blank), (widths, end) = found, ahead
    if end >= len(lines):
        return all(widths[at] == 1 for at in run)
    if all(widths[at] == 1 and len(dialect.split(lines[at][1])) < 2 for at in run):
        return True
    names = {lines[at][1].strip().casefold() for at in block.heading}
    if any(lines[at][1].strip().casefold() in names for at in run):
        return True
    named = any(widths[at] >= max(2, 0.75 * widths[end]) for at in run)
    other = _is_footer(lines, dialect, Block([], block.rows[-1:]), Block([], [end]))
    return named and (blank or other or len(run) > 1 or len(block.rows) < 3)


def _finish(lines: list[Line], dialect: Dialect, blocks: list[Block], widths: list[int]) -> list[Block]:
    """Blocks with their headers; rows under no heading belong to the header above."""
    if not any(block.rows for block in blocks):  # no numbers at all: the first line names the columns
        whole = [at for block in blocks for at in block.heading]
        blocks = [Block(whole[:1], whole[1:])]
    last: Block | None = None
    for block in blocks:
        width = Counter(len(trimmed(dialect.split(lines[at][1]))) for at in block.rows).most_common(1)
        block.width = width[0][0] if width else 0
        if _name(lines, dialect, block, widths) or last is None or not 0 < block.width <= len(last.header):
            pass
        elif len(block.rows) >= _MIN_ROWS or not _is_footer(lines, dialect, block, last):
            block.header, block.units = last.header, last.units
        while len(block.rows) > 1 and _is_summary(lines, dialect, block):
            block.rows.pop()
        if block.header:
            block.width = 0
        last = block if block.rows else last
    return [block for block in blocks if block.rows] or [Block([], [])]


def _is_summary(lines: list[Line], dialect: Dialect, block: Block) -> bool:
    """Whether the last row is a statistic: its name is in a column of numbers."""
    last = next(filter(None, dialect.split(lines[block.rows[-1]][1])), "")
    below = Block([], block.rows[-1:])
    return bool(_SUMMARY.fullmatch(last)) and _is_footer(lines, dialect, below, Block([], block.rows[:1]))


def _is_footer(lines: list[Line], dialect: Dialect, block: Block, above: Block) -> bool:
    """Return whether the first row has a text, such as *Mean*, in a column of numbers of `above`."""
    row, usual = (dialect.split(lines[at][1]) for at in (block.rows[0], above.rows[0]))
    pairs = [(a, b) for a, b in zip(row, usual, strict=False) if a and b]
    return any(not dialect.is_number(a) and dialect.is_number(b) for a, b in pairs)


def _name(lines: list[Line], dialect: Dialect, block: Block, widths: list[int]) -> bool:
    """Find header and units in a heading; rows without numbers directly under the header become rows."""
    heading = list(block.heading)
    below = dialect.split(lines[block.rows[0]][1]) if block.rows else []
    while len(heading) > 1 and (
        (widths[heading[-1]] < max(2, widths[heading[-2]]) and _is_divided(lines, dialect, heading[-1]))
        or _looks_alike(dialect.split(lines[heading[-1]][1]), below)
    ):
        heading.pop()
    late = block.heading[len(heading) :]
    if not heading or widths[heading[-1]] < 2:
        return False
    units: tuple[str, ...] = ()
    if len(heading) > 1 and _are_units(lines, dialect, heading[-1]):
        above = trimmed(dialect.split(lines[heading[-2]][1]))
        cells = dialect.split(lines[heading[-1]][1])
        if len(above) > 1 and len(trimmed(cells)) <= len(above):
            units, heading = tuple((cells + [""] * len(above))[: len(above)]), heading[:-1]
    block.header = tuple(trimmed(dialect.split(lines[heading[-1]][1])))
    block.units = units
    block.rows = [*late, *block.rows]
    block.heading = heading
    return True


def _looks_alike(cells: list[str], row: list[str]) -> bool:
    """Whether a cell has the pattern of the same cell in a row: ``000.png``, ``001.png``, ``10:31``."""
    shapes = ((re.sub(r"\d+", "0", a), re.sub(r"\d+", "0", b)) for a, b in zip(cells, row, strict=False))
    return any(a == b and "0" in a and re.search(r"[^\W\d]|:", a) for a, b in shapes)


def _is_divided(lines: list[Line], dialect: Dialect, at: int) -> bool:
    """Whether a line has two cells or more, full or empty, that are not all units."""
    return len(dialect.split(lines[at][1])) >= 2 and not _are_units(lines, dialect, at)


def _are_units(lines: list[Line], dialect: Dialect, at: int) -> bool:
    cells = [cell for cell in dialect.split(lines[at][1]) if cell]
    return bool(cells) and all(map(is_unit, cells))


def trimmed(cells: list[str]) -> list[str]:
    """Cells without the empty ones at the end."""
    return cells[: max((at + 1 for at, cell in enumerate(cells) if cell), default=0)]


def read_head(
    path: Path, lines: list[Line], blocks: list[Block], dialect: Dialect, comments: tuple[str, ...]
) -> Head:
    """Names and units of the columns of blocks.

    Raises
    ------
    PalpateError
        If there is no row, or the header names fewer columns than the rows have.
    """
    block = blocks[0]
    if not block.rows:
        raise PalpateError(f"{path} has no row below its header.", "Export the table again.", code="table-empty")
    first = block.rows[0]
    above = [text.strip() for _, text in lines[:first] if text.strip()]
    widths = [len(trimmed(dialect.split(lines[at][1]))) for at in block.rows[:HEAD]]
    if not block.header:
        heads: list[tuple[str, ...]] = []
        for one in dict.fromkeys((dialect, Dialect(" ", dialect.decimal))):
            split = [tuple(trimmed(one.split(text.lstrip("#/ ")))) for text in reversed(comments)]
            fits = [cells for cells in split if len(cells) == block.width and not any(map(dialect.is_number, cells))]
            heads += [cells for cells in fits if one == dialect or any(split_unit(cell)[1] for cell in cells)]
        named = [cells for cells in heads if not all(map(is_unit, cells))]
        units = heads[0] if named and heads[0] != named[0] else ()
        return Head(named[0] if named else ("",) * block.width, units, tuple(above))
    if min(widths) > len(block.header):
        raise PalpateError(
            f"{path}: row {lines[first][0] - 1} names {len(block.header)} columns, but row {lines[first][0]} has "
            f"{widths[0]} cells.",
            "Name every column once; a decimal comma needs another delimiter, and a name holds no delimiter.",
            code="header-length-wrong",
        )
    row = lines[block.heading[-1]][1].strip() if block.heading else ""
    return Head(block.header, block.units, tuple(text for text in above if text != row))
