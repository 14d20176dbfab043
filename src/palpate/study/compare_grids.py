"""Comparison of two grids: figures of common designs, and differences of settings, seeds and versions."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from palpate.core import PalpateError
from palpate.study.grid import Cell, Row, SpecificationGrid, design_spec, own_column

DESIGN = ("height_mm", "base_radius_mm", "thickness_mm", "markers")
"""Columns that identify a design; several rows of one design are matched in their order."""
METRICS = ("rmse_deg", "max_error_deg", "rmse_jitter_deg", "bound_deg")
SEEDS = ("seed", "dataset_seed", "learning_seed")
VARIES = "varies by design"
MOVED = 2.0
"""Standard deviations beyond which a row has changed: at random, one in twenty does."""
RECORDED, UNRECORDED = "recorded", "not recorded"

Design = tuple[Cell, ...]


@dataclass(frozen=True)
class Difference:
    """Difference between the origins of two grids.

    Attributes
    ----------
    name
        ``"spec obstacle.contact"``, ``"version numpy"``, ``"seed"``, …
    first, second
        Its value in each grid, as text; empty if missing.
    """

    name: str
    first: str
    second: str


@dataclass(frozen=True)
class Comparison:
    """Comparison of two grids.

    Attributes
    ----------
    rows
        One a design that both have: its skin and markers, for each metric ``…_a``, ``…_b`` and ``…_ratio`` (b/a), and
        ``moved``: the difference of ``rmse_deg`` over its standard deviation by the spreads of the repeats; empty
        without a spread.
    only_first, only_second
        Designs of one grid only.
    differences
        Differences in spec, seeds and versions.
    metrics
        Columns that were compared: those of the offset in place of the angle's if the grids have no angle.
    """

    rows: tuple[Row, ...]
    only_first: tuple[Row, ...]
    only_second: tuple[Row, ...]
    differences: tuple[Difference, ...]
    metrics: tuple[str, ...] = METRICS

    @property
    def moved(self) -> tuple[Row, ...]:
        """Rows whose ``rmse_deg`` differs by more than the spread of repeated trainings."""
        return tuple(row for row in self.rows if isinstance(row["moved"], float) and abs(row["moved"]) > MOVED)


def compare_grids(
    first: SpecificationGrid, second: SpecificationGrid, metrics: Sequence[str] = METRICS
) -> Comparison:
    """Compare the designs of two grids.

    Parameters
    ----------
    first, second
        The grids.
    metrics
        Columns to compare.

    Raises
    ------
    PalpateError
        If a metric is in neither grid, or is text.
    """
    known = {*first.columns, *second.columns}
    metrics = tuple(own_column(known, metric) for metric in metrics)
    for metric in metrics:
        cells = [row[metric] for grid in (first, second) if metric in grid.columns for row in grid.designs]
        if not cells and (first.designs or second.designs):
            raise PalpateError(
                f"Neither grid has a column '{metric}'.",
                "Choose a metric of `palpate study show`.",
                code="column-unknown",
            )
        if any(isinstance(cell, str) for cell in cells):
            raise PalpateError(
                f"'{metric}' is a text and has no ratio.", "Choose a column of numbers.", code="metric-is-text"
            )
    rows_a, rows_b = _by_design(first), _by_design(second)
    both = [design for design in rows_a if design in rows_b]
    return Comparison(
        rows=tuple(_side_by_side(rows_a[design], rows_b[design], metrics) for design in both),
        only_first=tuple(_dome(row) for design, row in rows_a.items() if design not in rows_b),
        only_second=tuple(_dome(row) for design, row in rows_b.items() if design not in rows_a),
        differences=_differences([(_facts(rows_a[design]), _facts(rows_b[design])) for design in both]),
        metrics=metrics,
    )


def _by_design(grid: SpecificationGrid) -> dict[Design, Row]:
    """Rows by skin, markers and index of the layout among those of equal number."""
    seen: Counter[Design] = Counter()
    found: dict[Design, Row] = {}
    for row in grid.designs:
        design = tuple(row[name] for name in DESIGN)
        found[(*design, seen[design])] = row
        seen[design] += 1
    return found


def _dome(row: Row) -> Row:
    return {name: row[name] for name in DESIGN}


def _side_by_side(row_a: Row, row_b: Row, metrics: Sequence[str]) -> Row:
    found = {**_dome(row_a), "moved": _moved(row_a, row_b)}
    for metric in metrics:
        a, b = row_a.get(metric), row_b.get(metric)
        found[f"{metric}_a"], found[f"{metric}_b"] = a, b
        numbers = isinstance(a, int | float) and isinstance(b, int | float) and a != 0
        found[f"{metric}_ratio"] = b / a if numbers else None  # type: ignore[operator]
    return found


def _moved(row_a: Row, row_b: Row) -> float | None:
    """Difference of the two RMSE over its standard deviation; `None` without repeats."""
    error, spread_of = (own_column(row_a, name) for name in ("rmse_deg", "rmse_spread_deg"))
    a, b = row_a.get(error), row_b.get(error)
    spreads = [row.get(spread_of) for row in (row_a, row_b)]
    known = [float(spread) for spread in spreads if isinstance(spread, int | float)]
    if not known or not isinstance(a, int | float) or not isinstance(b, int | float):
        return None
    # where one grid has no repeats, it is as uncertain as the other
    expected = math.hypot(known[0], known[-1])
    return (b - a) / expected if expected > 0 else math.copysign(math.inf, b - a) if b != a else 0.0


def _differences(pairs: Sequence[tuple[Mapping[str, str], Mapping[str, str]]]) -> tuple[Difference, ...]:
    names = dict.fromkeys(name for pair in pairs for facts in pair for name in facts)
    if any(facts.get("spec") == UNRECORDED for pair in pairs for facts in pair):
        names = dict.fromkeys(name for name in names if not name.startswith("spec "))  # nothing to hold it against
    found = []
    for name in names:
        values = {(a.get(name, ""), b.get(name, "")) for a, b in pairs}
        if any(a != b for a, b in values):
            sides = ({value[side] for value in values} for side in (0, 1))
            texts = [side.pop() if len(side) == 1 else VARIES for side in sides]
            found.append(Difference(name, *texts))
    return tuple(found)


def _facts(row: Row) -> dict[str, str]:
    """Spec, seeds and versions of a row, flattened."""
    facts = {name.replace("_", " "): str(row[name]) for name in SEEDS if row.get(name) is not None}
    facts |= {f"version {name}": version for name, version in json.loads(str(row.get("versions") or "{}")).items()}
    if not isinstance(row.get("spec"), str):
        return {**facts, "spec": UNRECORDED}
    return {**facts, "spec": RECORDED, **_flatten("spec", design_spec(row))}


def _flatten(name: str, value: Any) -> dict[str, str]:
    if not isinstance(value, dict):
        return {name: value if isinstance(value, str) else json.dumps(value)}
    joint = " " if name == "spec" else "."
    return {
        key: text
        for part in sorted(value)
        for key, text in _flatten(f"{name}{joint}{part}", value[part]).items()
        if not key.endswith(".seed")  # named as seeds
    }
