"""Reference numbers of the suite: CSV files in `reference/`."""

from __future__ import annotations

import csv
from importlib import resources
from importlib.resources.abc import Traversable

import numpy as np

from palpate.core import FloatArray


class Reference:
    """Rows of a reference file, by column.

    Parameters
    ----------
    rows
        Mapping from column to text.
    """

    def __init__(self, rows: list[dict[str, str]]) -> None:
        self._rows = rows

    def __len__(self) -> int:
        return len(self._rows)

    def __getitem__(self, column: str) -> FloatArray:
        """Values (n,) of a column in its unit; nan if the file lacks the column."""
        return np.array([float(row[column] or "nan") for row in self._rows])

    def where(self, **texts: str) -> Reference:
        """Rows whose columns start with these texts."""
        kept = [row for row in self._rows if all(row[key].startswith(text) for key, text in texts.items())]
        return Reference(kept)

    def between(self, column: str, low: float, high: float) -> Reference:
        """Rows whose value in a column lies in low…high."""
        return Reference([row for row in self._rows if low <= float(row[column]) <= high])

    def at(self, column: str, values: list[float]) -> Reference:
        """Rows whose value in a column is one of these."""
        return Reference([row for row in self._rows if np.isclose(float(row[column]), values, rtol=1e-9).any()])

    def joined(self, other: Reference) -> Reference:
        """Rows of the two references."""
        return Reference([*self._rows, *other._rows])

    def labels(self, *columns: str) -> list[str]:
        """Labels of the rows: their texts in these columns."""
        return [", ".join(row[column] for column in columns) for row in self._rows]


def read_reference(name: str, folder: Traversable | None = None) -> Reference:
    """Read a reference file by its name without ending, from a folder or from the package."""
    folder = folder or resources.files("palpate.verify") / "reference"
    with (folder / f"{name}.csv").open(encoding="utf-8") as file:
        return Reference(list(csv.DictReader(file)))
