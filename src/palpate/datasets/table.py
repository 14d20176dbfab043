"""Table of a recording: columns by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray
from palpate.core.tables import Column as Column
from palpate.core.tables import named_table

REST = "rest"
"""Press, or stem of an image's name, of the unloaded sensor."""


@dataclass(frozen=True, eq=False)
class RecordingTable:
    """A table by its columns.

    Attributes
    ----------
    name
        File that it was read from.
    columns
        Name → (n,) numbers, NaN where a cell is empty or no number, or text.
    faults
        Name of a column of numbers → sentence on its cells of text.
    notes
        Sentences on lines of the file that were passed over.
    first_line
        Line of the first row in its file.
    """

    name: str
    columns: Mapping[str, Column]
    faults: Mapping[str, str]
    notes: tuple[str, ...] = ()
    first_line: int = 2

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()))) if self.columns else 0

    def is_numeric(self, name: str) -> bool:
        """Whether a column holds numbers."""
        return self.columns[name].dtype.kind == "f"

    def rows(self, chosen: NDArray[Any]) -> RecordingTable:
        """The table with some of its rows only."""
        columns = {key: values[chosen] for key, values in self.columns.items()}
        return RecordingTable(self.name, columns, self.faults, self.notes, self.first_line)


def read_table(path: Path) -> RecordingTable:
    """Read the table of a recording: text of any dialect, JSON lines or Parquet.

    A unit from a row of units is written behind the column's name.

    Raises
    ------
    PalpateError
        If it cannot be read, has no row, or does not name its columns.
    """
    table = named_table(path, words=(REST,))
    names = [
        f"{name} [{table.unit(at)}]" if table.units and table.units[at] else name
        for at, name in enumerate(table.header)
    ]
    faults = {
        names[at]: f"line {fault.line} has '{fault.text[:30]}', which is no number"
        for at, fault in table.faults.items()
        if fault.text.casefold() not in ("nan", "null", "none")  # no number, as programs write it
    }
    return RecordingTable(
        path.name, dict(zip(names, table.columns, strict=True)), faults, table.notes, int(table.lines[0])
    )


def as_numbers(values: Column) -> FloatArray:
    """A column of numbers as such."""
    return np.asarray(values, dtype=float)
