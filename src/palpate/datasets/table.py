"""Tables of recordings as columns: CSV and JSON lines, read once from end to end in bounded memory."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError

REST = "rest"
"""Press, or stem of an image's name, of the untouched sensor."""
_ROWS = 20_000
"""Rows that are held as text at a time."""
_LONGEST = 240
"""Characters of a cell that are kept."""

Column = NDArray[Any]
"""(n,) numbers, NaN where a cell is empty or none, or text."""


@dataclass(frozen=True, eq=False)
class RecordingTable:
    """A table by its columns.

    Attributes
    ----------
    name
        File that it was read from.
    columns
        Name → (n,) numbers or text.
    faults
        Name of a column of numbers → what is wrong with some of its cells.
    """

    name: str
    columns: Mapping[str, Column]
    faults: Mapping[str, str]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()))) if self.columns else 0

    def is_numeric(self, name: str) -> bool:
        """Whether a column holds numbers."""
        return self.columns[name].dtype.kind == "f"

    def rows(self, chosen: NDArray[Any]) -> RecordingTable:
        """The table with some of its rows only."""
        return RecordingTable(self.name, {key: values[chosen] for key, values in self.columns.items()}, self.faults)


def read_table(path: Path) -> RecordingTable:
    """Read a table.

    Parameters
    ----------
    path
        The file; the first line of all but JSON lines names the columns.

    Raises
    ------
    PalpateError
        If it cannot be read, has no row, or a line has more cells than there are columns.
    """
    try:
        parts, faults = [], dict[str, str]()
        kinds: dict[str, bool] = {}
        rows = enumerate(_read_lines(path), 2 if path.suffix != ".jsonl" else 1)
        while part := list(islice(rows, _ROWS)):
            parts.append(_columns(part, kinds, faults))
    except (OSError, UnicodeDecodeError, csv.Error, json.JSONDecodeError) as error:
        raise PalpateError(
            f"{path.name} cannot be read: {error}.",
            "Give a CSV or JSON lines, a row an image.",
            code="table-unreadable",
        ) from error
    if not parts:
        raise PalpateError(f"{path.name} has no row below its head.", "Give a row an image.", code="table-empty")
    names = list(dict.fromkeys(name for part in parts for name in part))
    columns = {name: _join([part.get(name) for part in parts], parts) for name in names}
    return RecordingTable(path.name, columns, faults)


def _read_lines(path: Path) -> Iterator[dict[str, Any]]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        if path.suffix == ".jsonl":
            for line in file:
                if line.strip():
                    found = json.loads(line)
                    if not isinstance(found, dict):
                        raise PalpateError(
                            f"{path.name} has a line that is no object.",
                            "Write {...} on each line.",
                            code="table-line-not-object",
                        )
                    yield flatten(found)
            return
        head = file.readline()
        file.seek(0)
        mark = max((",", ";", "\t"), key=head.count)
        table = csv.DictReader(file, delimiter=mark, skipinitialspace=True)
        _check_head(path, table.fieldnames)
        for row in table:
            if None in row:
                raise PalpateError(
                    f"{path.name}, line {table.line_num}: {len(row[None])} more cells than columns.",
                    "Name every column, and write decimals with a point.",
                    code="row-length-wrong",
                )
            yield row


def _check_head(path: Path, names: Any) -> None:
    names = list(names or ())
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise PalpateError(
            f"{path.name} has two columns named {', '.join(twice)}.", "Name each column once.", code="column-twice"
        )
    if names and all(_is_number(name) for name in names):
        raise PalpateError(
            f"{path.name} has numbers in its first line: {', '.join(names[:4])}.",
            "Name the columns in the first line.",
            code="header-missing",
        )


def flatten(row: Mapping[str, Any]) -> dict[str, Any]:
    """A nested row as one of plain cells: ``{"pose": [1, 2]}`` gives ``pose_0`` and ``pose_1``."""
    flat: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, Mapping):
            flat |= {f"{key}_{inner}": cell for inner, cell in flatten(value).items()}
        elif isinstance(value, list):
            flat |= flatten({f"{key}_{number}": cell for number, cell in enumerate(value)})
        else:
            flat[key] = value
    return flat


def _columns(
    part: list[tuple[int, dict[str, Any]]], kinds: dict[str, bool], faults: dict[str, str]
) -> dict[str, Column]:
    names = list(dict.fromkeys(name for _, row in part for name in row))
    found = {}
    for name in names:
        cells = [row.get(name) for _, row in part]
        texts = ["" if cell is None else str(cell).strip()[:_LONGEST] for cell in cells]
        numbers = np.array([_number(text) for text in texts])
        bad = np.isnan(numbers) & np.array([text.lower() not in ("", "nan") for text in texts])
        if name not in kinds:
            filled = sum(text != "" for text in texts)
            kinds[name] = filled > 0 and bad.sum() <= 0.5 * filled and not _numbers_presses(texts, numbers)
        if not kinds[name]:
            found[name] = np.array(texts)
            continue
        found[name] = numbers
        if bad.any() and name not in faults:
            first = int(np.argmax(bad))
            faults[name] = f"line {part[first][0]} has '{texts[first][:30]}', which is no number"
    return found


def _numbers_presses(texts: list[str], numbers: FloatArray) -> bool:
    """Whether cells are numbers of presses, with images at rest among them."""
    given = numbers[np.isfinite(numbers)]
    return REST in map(str.lower, texts) and bool((given == np.round(given)).all())


def _join(parts: list[Column | None], all_parts: list[dict[str, Column]]) -> Column:
    text = any(part is not None and part.dtype.kind != "f" for part in parts)
    lengths = [len(next(iter(part.values()))) for part in all_parts]
    whole = [
        np.full(length, "" if text else np.nan) if part is None else part
        for part, length in zip(parts, lengths, strict=True)
    ]
    return np.concatenate([part.astype(str, copy=False) if text else part for part in whole])


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float({"true": 1.0, "false": 0.0}.get(text.lower(), "nan"))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except (ValueError, TypeError):
        return False
    return True


def as_numbers(values: Column) -> FloatArray:
    """A column of numbers as such."""
    return np.asarray(values, dtype=float)
