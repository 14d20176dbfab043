"""Tables as columns: text of every dialect, JSON lines and Parquet, with units and row numbers.

Every command that reads a table does so by `read_table`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core.arrays import FloatArray, IntArray
from palpate.core.errors import PalpateError
from palpate.core.extra import load_extra
from palpate.core.json_rows import flatten, load_rows
from palpate.core.table_text import (
    COMMENTS,
    Block,
    find_blocks,
    find_dialect,
    parse_number,
    read_head,
    split_quantity,
)
from palpate.core.text_lines import HEAD, Line, read_bytes, split_lines
from palpate.core.units import split_unit

_PART = 20_000
"""Number of rows that are held as text at a time. By hand."""
_LONGEST = 240
"""Maximum number of characters of a cell. By hand."""
_MANY = 12
"""Minimum number of rows of a second table that makes the choice ambiguous. By hand."""
_JSON = (".jsonl", ".ndjson", ".json")

Column = NDArray[Any]
"""(n,) numbers, NaN for empty cells and texts, or (n,) texts."""


@dataclass(frozen=True)
class Fault:
    """Text cell in a column of numbers: line of the file, from 1, and text."""

    line: int
    text: str


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of a file, and the text around them.

    Attributes
    ----------
    path
        The file.
    header
        Names of the columns; empty texts if the file has no header.
    units
        Texts of a row of units below the header; empty if there is no such row.
    preamble
        Lines above the header, and the comments.
    columns
        One array (n,) per column: numbers, NaN for empty cells and texts, or texts.
    faults
        First text cell of each column of numbers that has one.
    lines
        (n,) line of each row in the file, from 1.
    block
        (n,) index of the group of rows between headings or blank lines.
    decimal
        Decimal mark.
    skipped
        Number of rows left out by thinning.
    notes
        Sentences on skipped lines.
    """

    path: Path
    header: tuple[str, ...]
    units: tuple[str, ...]
    preamble: tuple[str, ...]
    columns: tuple[Column, ...]
    faults: Mapping[int, Fault]
    lines: IntArray
    block: IntArray
    decimal: str = "."
    skipped: int = 0
    notes: tuple[str, ...] = field(default=())

    def __len__(self) -> int:
        return len(self.lines)

    @property
    def named(self) -> bool:
        """Whether the file has column names."""
        return any(self.header)

    def is_numeric(self, column: int) -> bool:
        """Whether a column holds numbers."""
        return self.columns[column].dtype.kind == "f"

    def numbers(self, column: int) -> FloatArray:
        """Return the numbers (n,) of a column; NaN in an empty cell."""
        return np.asarray(self.columns[column], float)

    def unit(self, column: int) -> str:
        """Return the unit of a column, from the row of units or its name; may be empty."""
        row = self.units[column].strip("()[]{}<>（）【】 ") if self.units else ""
        return row or split_unit(self.header[column])[1]

    def bare_names(self) -> tuple[str, ...]:
        """Return the names of the columns without their units."""
        return tuple(split_unit(name)[0] for name in self.header)


def read_table(
    path: Path,
    *,
    delimiter: str | None = None,
    decimal: str | None = None,
    max_rows: int | None = None,
    words: Sequence[str] = (),
) -> Table:
    """Read the table of a file; of several, the one with the most rows.

    Parameters
    ----------
    path
        Text in any encoding and dialect, JSON lines, or Parquet.
    delimiter, decimal
        Delimiter of cells and decimal mark; `None` to detect them.
    max_rows
        Maximum number of rows; a longer text is thinned evenly. `None` reads all.
    words
        Cells that make a column of whole numbers a column of names, such as ``rest`` among press numbers.

    Raises
    ------
    PalpateError
        If the file cannot be read, contains no table, or a row has more cells than there are columns.
    """
    if path.suffix.lower() in (".parquet", ".pq"):
        return _read_parquet(path, words)
    data = read_bytes(path)
    if path.suffix.lower() in _JSON or data[:1] == b"{":
        return _read_json(path, data, words)
    lines, skipped = split_lines(data, max_rows)
    mark, lines = _named_delimiter(lines)
    kept = [line for line in lines if not line[1].lstrip().startswith(COMMENTS)]
    comments = [(number, text.strip()) for number, text in lines[:HEAD] if text.lstrip().startswith(COMMENTS)]
    if not any(text.strip() for _, text in kept):
        raise PalpateError(f"{path} is empty.", "Export the table again.", code="table-empty")
    dialect = find_dialect(path, kept, delimiter or mark, decimal)
    blocks, notes = _choose(path, find_blocks(kept, dialect))
    first = kept[blocks[0].rows[0]][0] if blocks[0].rows else 0
    head = read_head(path, kept, blocks, dialect, tuple(text for number, text in comments if number < first))
    columns = _Columns(len(head.names), dialect.decimal, words)
    numbers = [kept[at][0] for block in blocks for at in block.rows]
    rows = (dialect.split(kept[at][1]) for block in blocks for at in block.rows)
    while part := list(islice(rows, _PART)):
        columns.add(path, part, numbers)
    names, units, found = _expand(head.names, columns.merge_units(head.units), columns.join())
    return Table(
        path=path,
        header=names,
        units=units,
        preamble=(*head.above, *(text for _, text in comments)),
        columns=found,
        faults=columns.faults,
        lines=np.array(numbers, np.int64),
        block=np.repeat(np.arange(len(blocks)), [len(block.rows) for block in blocks]),
        decimal=dialect.decimal,
        skipped=skipped,
        notes=notes,
    )


def _named_delimiter(lines: list[Line]) -> tuple[str | None, list[Line]]:
    """Delimiter by a first line ``sep=;``, and the lines below it."""
    first = lines[0][1].strip().strip('"') if lines else ""
    if first.lower().startswith("sep=") and len(first) <= 5:
        return first[4:] or "\t", lines[1:]
    return None, lines


def _choose(path: Path, blocks: list[Block]) -> tuple[list[Block], tuple[str, ...]]:
    """Blocks of the largest table, and notes on smaller ones."""
    groups: dict[Any, list[Block]] = {}
    for block in blocks:
        groups.setdefault((tuple(text.casefold() for text in block.header), block.width), []).append(block)
    order = sorted(groups.values(), key=lambda group: -sum(len(block.rows) for block in group))
    counts = [sum(len(block.rows) for block in group) for group in order]
    if len(counts) > 1 and counts[1] >= max(_MANY, counts[0] // 2):
        raise PalpateError(
            f"{path} contains two tables with different columns, of {counts[0]} and {counts[1]} rows.",
            "Save each table in a separate file.",
            code="table-several",
        )
    others = [(block, len(block.rows)) for group in order[1:] for block in group if len(block.rows) > 1]
    return order[0], tuple(f"another table of {count} rows was skipped" for _, count in others[:3])


class _Columns:
    """Columns that grow by parts of rows."""

    def __init__(self, width: int, decimal: str, words: Sequence[str]) -> None:
        self._parts: list[list[Column]] = [[] for _ in range(width)]
        self._decimal, self._words = decimal, {word.casefold() for word in words}
        self._numeric: dict[int, bool] = {}
        self._units: dict[int, str] = {}
        self._count = 0
        self.faults: dict[int, Fault] = {}

    def add(self, path: Path, rows: list[list[str]], lines: Sequence[int]) -> None:
        width = len(self._parts)
        for at, row in enumerate(rows):
            if len(row) > width and any(row[width:]):
                raise PalpateError(
                    f"{path}: row {lines[self._count + at]} has {max(k + 1 for k, c in enumerate(row) if c)} cells "
                    f"where {width} are usual.",
                    "Correct the row; a decimal comma needs another delimiter.",
                    code="row-length-wrong",
                )
        for column in range(width):
            texts = [row[column][:_LONGEST] if column < len(row) else "" for row in rows]
            self._parts[column].append(self._convert(column, texts, lines))
        self._count += len(rows)

    def _convert(self, column: int, texts: list[str], lines: Sequence[int]) -> Column:
        filled = np.array([text != "" for text in texts], bool)
        if self._numeric.get(column) is False:
            return np.array(texts)
        values = np.array([parse_number(text, self._decimal) for text in texts], float)
        bad = filled & ~np.isfinite(values)
        if column in self._units or (column not in self._numeric and bad.any() and (bad == filled).all()):
            quantities = [split_quantity(text) for text in texts]
            units = {unit for (_, unit), there in zip(quantities, filled, strict=True) if there}
            if unit := self._units.get(column) or (units.pop() if len(units) == 1 else ""):
                self._units[column] = unit
                numbers = [number if own == unit else "nan" for number, own in quantities]
                values = np.array([parse_number(number, self._decimal) for number in numbers], float)
                bad = filled & ~np.isfinite(values)
        wrong = int(sum(texts[at].casefold() not in ("nan", "inf", "-inf") for at in np.flatnonzero(bad)))
        if column not in self._numeric and filled.any():
            names = self._words & {texts[at].casefold() for at in np.flatnonzero(bad)}
            whole = values[np.isfinite(values)]
            named = bool(names) and bool((whole == np.round(whole)).all())
            self._numeric[column] = bool(wrong <= 0.5 * filled.sum() and not named)
            if not self._numeric[column]:
                return np.array(texts)
        if bad.any() and column not in self.faults:
            first = int(np.argmax(bad))
            self.faults[column] = Fault(int(lines[self._count + first]), texts[first])
        return values

    def merge_units(self, units: tuple[str, ...]) -> tuple[str, ...]:
        """Row of units with those that stand in all cells of a column."""
        if not self._units:
            return units
        return tuple(self._units.get(at, units[at] if units else "") for at in range(len(self._parts)))

    def join(self) -> tuple[Column, ...]:
        """Whole columns; a column is text if any part of it is."""
        found = []
        for parts in self._parts:
            text = any(part.dtype.kind == "U" for part in parts)
            whole = [
                np.full(len(part), "") if text and part.dtype.kind == "f" and not np.isfinite(part).any() else part
                for part in parts
            ]
            found.append(np.concatenate([part.astype(str) if text else part for part in whole] or [np.empty(0)]))
        return tuple(found)


def _expand(
    names: tuple[str, ...], units: tuple[str, ...], columns: tuple[Column, ...]
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[Column, ...]]:
    """Add a column for each number of lists that are the cells of a column: ``[1, 2]``.

    The pose ``p[…]`` of a UR robot, a position and a rotation vector, gets the names of its RTDE.
    """
    for name, column in zip(names, columns, strict=True):
        if column.dtype.kind != "U" or not len(column) or "[" not in str(column[0])[:2]:
            continue
        lists = [cell.removeprefix("p") for cell in column.tolist()]
        if all(cell[:1] + cell[-1:] == "[]" for cell in lists):
            cells = [re.split(r"[\s,;]+", cell[1:-1].strip()) for cell in lists]
            values = np.array([[parse_number(text) for text in row] for row in cells if len(row) == len(cells[0])])
            of_robot = str(column[0]).startswith("p") and values.shape[1:] == (6,)
            name = "actual_TCP_pose" if of_robot else name
            if len(values) == len(column) and np.isfinite(values).all() and f"{name}_0" not in names:
                names = (*names, *(f"{name}_{at}" for at in range(values.shape[1])))
                units = (*units, *("",) * values.shape[1]) if units else ()
                columns = (*columns, *values.T)
    return names, units, columns


def _read_json(path: Path, data: bytes, words: Sequence[str]) -> Table:
    def objects() -> Iterator[tuple[int, Any]]:
        if path.suffix.lower() == ".json" and (whole := load_rows(data)) is not None:
            yield from enumerate(whole, start=1)
            return
        for number, line in enumerate(data.splitlines(), start=1):
            if line.strip():
                yield number, json.loads(line)

    numbers, rows = [], []
    try:
        for number, found in objects():
            if not isinstance(found, dict):
                raise PalpateError(
                    f"{path.name} has a line without an object (line {number}).",
                    "Write {...} on each line.",
                    code="table-line-not-object",
                )
            numbers.append(number)
            rows.append(flatten(found))
    except (ValueError, RecursionError) as error:
        reason = str(error).split(":")[0]
        raise PalpateError(
            f"{path.name} cannot be read as JSON lines: {reason}.",
            "Write one object {...} on each line.",
            code="table-unreadable",
        ) from error
    return _of_records(path, rows, numbers, words)


def _read_parquet(path: Path, words: Sequence[str]) -> Table:
    parquet = load_extra("pyarrow.parquet", "parquet", "pyarrow")
    try:
        content = parquet.read_table(path).to_pylist()
    except Exception as error:  # pyarrow raises errors of its own kinds for files that are damaged
        raise PalpateError(
            f"{path} cannot be read as Parquet: {str(error).splitlines()[0][:120]}.",
            "Write the file again, or save it as CSV.",
            code="file-unreadable",
        ) from error
    return _of_records(path, [flatten(row) for row in content], list(range(1, len(content) + 1)), words)


def _of_records(path: Path, rows: list[dict[str, Any]], numbers: list[int], words: Sequence[str]) -> Table:
    names = tuple(dict.fromkeys(str(name) for row in rows for name in row))
    if not names:
        raise PalpateError(f"{path.name} has no row.", "Write one object a row.", code="table-empty")
    columns = _Columns(len(names), ".", words)
    for start in range(0, len(rows), _PART):
        part = [["" if row.get(name) is None else str(row[name]).strip() for name in names] for row in
                rows[start : start + _PART]]  # fmt: skip
        columns.add(path, part, numbers)
    lines = np.array(numbers, np.int64)
    return Table(path, names, (), (), columns.join(), columns.faults, lines, np.zeros(len(lines), np.int64))


def named_table(path: Path, words: Sequence[str] = ()) -> Table:
    """Read a table whose file names every column once.

    Raises
    ------
    PalpateError
        If the file cannot be read, or its header is missing or has a name twice.
    """
    table = read_table(path, words=words)
    if not table.named:
        raise PalpateError(
            f"{path.name} does not name its columns.", "Name the columns in the first line.", code="header-missing"
        )
    twice = sorted({name for name in table.header if name and table.header.count(name) > 1})
    if twice:
        raise PalpateError(
            f"{path.name} has two columns named {', '.join(twice)}.", "Name each column once.", code="column-twice"
        )
    return replace(table, header=tuple(name or f"column {at}" for at, name in enumerate(table.header, start=1)))
