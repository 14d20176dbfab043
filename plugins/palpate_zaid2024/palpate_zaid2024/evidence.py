"""A grid as evidence: figures by design, and the designs that are missing for a claim."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from palpate.core import PalpateError, rename_columns
from palpate.study import Cell, Row, SpecificationGrid, design_spec, rows_for_design

HEIGHTS, THICKNESSES, MARKERS = (10.0, 20.0, 30.0), (1.0, 2.0, 3.0, 4.0), (7, 37, 91, 169)
"""The paper's designs (mm, mm, 1)."""
BASE_RADIUS_MM = 20.0

Found = TypeVar("Found")
Dome = tuple[float, float]
"""Height and thickness (mm)."""
Design = tuple[float, float, int]
DESIGNS: tuple[Design, ...] = tuple((h, t, m) for h in HEIGHTS for t in THICKNESSES for m in MARKERS)
"""Height (mm), thickness (mm) and markers of the paper's 48 designs."""


class MissingEvidenceError(Exception):
    """Error if the grid lacks designs that a claim needs.

    Parameters
    ----------
    designs
        Height, thickness and markers of each.
    reasons
        Failures that the study recorded for these designs.
    """

    def __init__(self, designs: Iterable[Design], reasons: Iterable[str] = ()) -> None:
        self.designs = tuple(dict.fromkeys(designs))
        self.reasons = tuple(dict.fromkeys(reason for reason in reasons if reason))
        super().__init__(_missing_sentence(self.designs, self.reasons))


@dataclass(frozen=True)
class Evidence:
    """One grid, accessed by design.

    Attributes
    ----------
    grid
        Rows of one study.
    folder
        Name of its folder, for messages.
    built
        Predicted accuracy of built units of the paper's designs (`read_built`).
    """

    grid: SpecificationGrid
    folder: str
    built: Mapping[Design, Row] = field(default_factory=dict)

    @cached_property
    def rows(self) -> Mapping[Design, Row]:
        """Rows of the paper's designs; the first row if a design has several."""
        found: dict[Design, Row] = {}
        for row in self.grid.designs:
            if row["base_radius_mm"] == BASE_RADIUS_MM:
                key = (_number(row["height_mm"]), _number(row["thickness_mm"]), int(_number(row["markers"])))
                found.setdefault(key, row)
        return found

    @property
    def label(self) -> str:
        """Contact law and learning preset, e.g. ``"no-slip, best"``; the folder if the grid has neither."""
        spec = next((design_spec(row) for row in self.grid.designs if row.get("spec")), {})
        parts = (spec.get("obstacle", {}).get("contact"), spec.get("learning", {}).get("preset"))
        words = ", ".join(_word(part) for part in parts if part is not None)
        return words or self.folder

    def figures(self, column: str, designs: Iterable[Design] = DESIGNS) -> dict[Design, float]:
        """Return the number of each design in a column.

        Raises
        ------
        MissingEvidenceError
            If any of the designs is missing, or its cell is empty.
        """
        return {design: _number(cell) for design, cell in self._cells(column, designs).items()}

    def has(self, column: str) -> bool:
        """Return whether each of the paper's designs has a number in a column."""
        return all(isinstance(self._cell(column, design), int | float) for design in DESIGNS)

    def domes(self, column: str, domes: Iterable[Dome]) -> dict[Dome, float]:
        """Return one number per dome, from the first of its rows with this number; errors: see `figures`."""
        found: dict[Dome, Cell] = self._of_domes(lambda row: row.get(column), domes)
        return {dome: _number(cell) for dome, cell in found.items()}

    def branches(self, domes: Iterable[Dome]) -> dict[Dome, list[tuple[float, str]]]:
        """Return tilt (degrees) and branch at full depth of every press, by dome; errors: see `figures`."""
        numbers = {id(row): number for number, row in enumerate(self.grid.designs)}
        found = self._of_domes(lambda row: rows_for_design(self.grid.presses, numbers[id(row)]) or None, domes)
        return {
            dome: [(_number(row["tilt_deg"]), str(row["branch"])) for row in rows] for dome, rows in found.items()
        }

    def domes_or_none(self, column: str, domes: Iterable[Dome]) -> dict[Dome, float | None]:
        """Return one number per dome; `None` for a solved dome to which the figure does not apply."""
        found = self._of_domes(lambda row: row.get("presses"), domes)
        return {dome: next(self._numbers(column, dome), None) for dome in found}

    def _cell(self, column: str, design: Design) -> Cell:
        own = self.rows.get(design, {}).get(column)
        return self.built.get(design, {}).get(column) if own is None else own

    def _cells(self, column: str, designs: Iterable[Design]) -> dict[Design, Cell]:
        found = {design: self._cell(column, design) for design in designs}
        missing = [design for design, cell in found.items() if cell is None]
        if missing:
            raise MissingEvidenceError(missing, (str(self.rows.get(one, {}).get("failure") or "") for one in missing))
        return found

    def _of_domes(self, find: Callable[[Row], Found | None], domes: Iterable[Dome]) -> dict[Dome, Found]:
        found, missing, reasons = {}, [], []
        for dome in domes:
            rows = self._rows_of(dome)
            first = next((what for row in rows if (what := find(row)) is not None), None)
            if first is not None:
                found[dome] = first
            else:
                missing += [(*dome, markers) for markers in MARKERS]
                reasons += [str(row.get("failure") or "") for row in rows]
        if missing:
            raise MissingEvidenceError(missing, reasons)
        return found

    def _rows_of(self, dome: Dome) -> list[Row]:
        return [row for (height, thickness, _), row in self.rows.items() if (height, thickness) == dome]

    def _numbers(self, column: str, dome: Dome) -> Iterator[float]:
        cells = (row.get(column) for row in self._rows_of(dome))
        return (float(cell) for cell in cells if isinstance(cell, int | float))


def read_built(path: Path) -> dict[Design, Row]:
    """Read the accuracy of built units, by design, from a table of `palpate calibration predict`.

    Raises
    ------
    PalpateError
        If the file is not such a table.
    """
    found: dict[Design, Row] = {}
    try:
        with path.open(encoding="utf-8", newline="") as lines:
            for row in map(rename_columns, csv.DictReader(lines)):
                key = (float(row["height_mm"]), float(row["thickness_mm"]), int(row["markers"]))
                when = "calibrated" if int(row["calibration_presses"]) else "built"
                figures = {f"{when}_{name}": float(row[name]) for name in ("rmse_deg", "p95_deg")}
                found[key] = {**found.get(key, {}), **figures}
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise PalpateError(
            f"{path} is not a table of built units: {error}.",
            "Make the table again: palpate calibration predict.",
            code="units-table-unreadable",
        ) from error
    return found


def _missing_sentence(designs: Iterable[Design], reasons: Iterable[str]) -> str:
    """Describe the missing designs, grouped by dome."""
    layouts: dict[tuple[float, float], list[int]] = {}
    for height, thickness, markers in designs:
        layouts.setdefault((height, thickness), []).append(markers)
    heights: dict[tuple[float, tuple[int, ...]], list[float]] = {}
    for (height, thickness), counts in layouts.items():
        heights.setdefault((height, tuple(counts)), []).append(thickness)
    words = []
    for (height, absent), thicknesses in heights.items():
        shown = "" if set(absent) >= set(MARKERS) else f" with {', '.join(map(str, absent))} markers"
        words.append(f"H{height:g} T{', T'.join(f'{thickness:g}' for thickness in thicknesses)}{shown}")
    why = "".join(f" ({reason})" for reason in list(reasons)[:2])
    return f"needs {'; '.join(words)}{why}"


def _word(part: Any) -> str:
    return f"friction {part:g}" if isinstance(part, int | float) else str(part)


def _number(cell: Cell) -> float:
    if isinstance(cell, int | float):
        return float(cell)
    raise TypeError(f"{cell!r} is not a number")
