"""Specification grid: figures of every design, in four tables."""

from __future__ import annotations

import json
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Cell = float | int | str | None
"""Number, text, or `None` for a failed design or an inapplicable figure."""

Row = Mapping[str, Cell]

TABLES = ("by_depth", "by_tilt", "presses")
"""Tables other than that of the designs; the first column of each is ``design``."""


def design_spec(row: Row) -> dict[str, Any]:
    """Return the settings of a row's study, under the keys of today; empty if the row lacks them."""
    spec: dict[str, Any] = json.loads(str(row.get("spec") or "{}"))
    if "wall" in spec:  # until 0.2
        spec["obstacle"] = spec.pop("wall")
    return spec


def own_column(columns: Container[str], column: str) -> str:
    """Column of a grid for one of an angle: the offset's in mm, if the obstacles have no tilt."""
    offset = f"{column.removesuffix('_deg')}_mm"
    return offset if column not in columns and column.endswith("_deg") and offset in columns else column


def ranking_column(columns: Container[str]) -> str:
    """Column for the rank of designs: the predicted RMSE as built, otherwise that of trained networks."""
    names = ("built_rmse_deg", "rmse_jitter_deg", "rmse_jitter_mm", "rmse_deg", "rmse_mm")
    return next((name for name in names if name in columns), "rmse_deg")


UNITS = {"_mm": "mm", "_deg": "deg", "_mpa": "MPa", "_n": "N", "_px": "px"}


@dataclass(frozen=True)
class SpecificationGrid:
    """Specification grid: accuracy of every design, and its settings.

    Every row of a table has every column of it. Names of columns end in their unit (``_mm``, ``_deg``, ``_mpa``,
    ``_n``). In the last three tables ``design`` is the number of the row in `designs`, from 0.

    Attributes
    ----------
    designs
        One row a design, in the order of the study.
    by_depth
        One a design and depth: ``design``, ``depth_mm``, then ``rmse_deg``, ``max_error_deg``, both ``_jitter``,
        ``validation_samples``, ``bound_deg``, ``bound_pitman_deg``, ``bound_floor_deg``, ``rmse_over_bound``.
    by_tilt
        One a design and interval of true tilt: ``design``, ``tilt_from_deg``, ``tilt_to_deg``, then the errors.
    presses
        One a design and press: ``design``, ``tilt_deg``, ``ended`` and ``ended_depth_mm``, ``force_n`` and ``branch``
        in the deepest image, ``peak_stress_mpa``, ``displacement_max_mm``, ``displacement_mean_mm``, ``apex_gap_mm``;
        ``azimuth_deg`` if the skin is no body of revolution.

    Notes
    -----
    `grid_column` has heading, unit and meaning of a column. Errors pool both components of the angle, as in the
    paper, over the images of the held-out presses; those per axis are ``rmse_rx_deg``, …, ``bias_ry_deg``. Without a
    prediction of built units there are no columns ``built_…`` and ``calibrated_…``. Intervals are of the level
    ``interval_level``, on ``interval_presses`` presses that neither trained nor calibrated it; ``flagged_ood`` is the
    share of images out of the trained range. ``displacement_max_mm`` and ``apex_gap_mm`` are the maxima over all
    presses in their deepest images. ``spec`` and ``versions`` are JSON.
    """

    designs: tuple[Row, ...]
    by_depth: tuple[Row, ...] = ()
    by_tilt: tuple[Row, ...] = ()
    presses: tuple[Row, ...] = ()

    def __post_init__(self) -> None:
        for table in ("designs", *TABLES):
            rows = getattr(self, table)
            if any(tuple(row) != tuple(rows[0]) for row in rows):
                raise ValueError(f"the rows of {table} do not have the same columns")
            if table in TABLES and not all(row["design"] in range(len(self.designs)) for row in rows):
                raise ValueError(f"{table} has a row of no design")

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of `designs`, in order."""
        return tuple(self.designs[0]) if self.designs else ()

    def select(self, designs: Sequence[Row]) -> SpecificationGrid:
        """Return the grid with these designs only, in the order given."""
        numbers = {id(row): number for number, row in enumerate(self.designs)}
        places = {numbers[id(row)]: place for place, row in enumerate(designs)}
        tables = (
            tuple({**row, "design": places[row["design"]]} for row in getattr(self, table) if row["design"] in places)
            for table in TABLES
        )
        return SpecificationGrid(tuple(designs), *tables)


def rows_for_design(table: Sequence[Row], design: int) -> tuple[Row, ...]:
    """Return the rows of `by_depth`, `by_tilt` or `presses` of one design, by its number in the grid."""
    return tuple(row for row in table if row["design"] == design)


def design_label(row: Row) -> str:
    """Return the label of a design, e.g. ``"H20 T2, 169 markers"``.

    Examples
    --------
    >>> design_label({"height_mm": 20.0, "thickness_mm": 2.0, "markers": 169})
    'H20 T2, 169 markers'
    """
    return f"H{row['height_mm']:g} T{row['thickness_mm']:g}, {row['markers']} markers"


def column_unit(column: str) -> str:
    """Return the unit of a column by its suffix; empty for a pure number or text.

    Examples
    --------
    >>> column_unit("rmse_depth_mm"), column_unit("markers")
    ('mm', '')
    """
    return next((unit for suffix, unit in UNITS.items() if column.endswith(suffix)), "")
