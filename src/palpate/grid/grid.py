"""The noun of the stage: one row of figures a design."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = float | int | str | None
"""A figure, a word, or nothing where the chain broke or the figure does not apply."""

Row = Mapping[str, Cell]

MAIN_COLUMNS = (
    "height_mm",
    "thickness_mm",
    "markers",
    "rmse_deg",
    "max_error_deg",
    "rmse_jitter_deg",
    "max_error_jitter_deg",
    "rmse_spread_deg",
    "limit_deg",
    "rmse_over_limit",
    "interval_coverage",
    "travel_mm",
    "peak_stress_mpa",
    "force_n",
    "bistable_from_mm",
    "samples",
)
"""Columns that a person reads first."""

_AT_DEPTH = re.compile(r"_at_(\d+)_(\d+)mm")
_AT_TILT = re.compile(r"_at_tilt_(\d+)_to_(\d+)")

UNITS = {"_mm": "mm", "_deg": "deg", "_mpa": "MPa", "_n": "N", "_px": "px"}


@dataclass(frozen=True)
class SpecificationGrid:
    """The paper's result: how good each design is, and what it was made from.

    Attributes
    ----------
    rows
        One a design, in the order of the study; every row has every column.
    columns
        Names in order; a suffix names the unit (``_mm``, ``_deg``, ``_mpa``, ``_n``).

    Notes
    -----
    ``rmse_deg`` and ``max_error_deg`` pool both components of the angle, as in the paper, over the images of the
    held-out presses; ``_jitter`` is the same with jittered pixels. ``rmse_spread_deg`` is the standard deviation of
    ``rmse_deg`` over the repeats of the training, each by itself. ``limit_deg`` is the least-squares bound on
    ``rmse_jitter_deg`` over the same images, ``limit_pitman_deg`` that of the posterior mean, ``rmse_over_limit`` the
    jittered RMSE over the first. ``interval_coverage`` is the share of true angles inside their interval of the level
    ``interval_level``, on jittered images of presses that neither trained nor calibrated it (``interval_presses`` of
    them), ``interval_half_width_deg`` its mean half-width; ``called_outside`` the share of those images that were
    called out of the trained range. ``rmse_rx_deg``, …, ``bias_ry_deg`` and ``rmse_depth_mm`` are per axis,
    ``rmse_at_2_4mm_deg``, … per depth (here 2.4 mm), ``rmse_at_tilt_0_to_2_deg``, … per interval of true tilt.
    ``travel_mm`` is the distance in space of a marker from rest, as mean over the markers and over the sampled
    poses at the greatest depth. ``peak_stress_mpa`` is the greatest von Mises stress in any image of any press,
    ``force_n`` the wall's force in the deepest image of the press of least tilt, ``peak_stress_straight_mpa`` the
    stress of that press alone. ``displacement_max_mm`` and ``apex_gap_mm`` are the greatest over all presses in their
    deepest images; ``branch_by_tilt`` and ``depth_by_tilt_mm`` say for each tilt how its press ended. From
    ``bistable_from_mm`` on the dome has a second, inverted state (empty: none up to the greatest depth). ``spec`` is
    JSON.
    """

    rows: tuple[Row, ...]
    columns: tuple[str, ...]

    def __post_init__(self) -> None:
        for row in self.rows:
            if tuple(row) != self.columns:
                raise ValueError(f"row {dict(row)} does not have the columns {self.columns}")

    def plot(self, metric: str = "rmse_deg", kind: str = "heat") -> Figure:
        """Draw one metric, as `palpate.grid.plot_grid` does, without writing it.

        Raises
        ------
        PalpateError
            If there is no such kind or metric, or no design has the figure.
        """
        from palpate.grid.plot import draw_plot, refuse_unknown  # here, because pictures know results

        refuse_unknown(self, kind, metric)
        return draw_plot(self, kind, metric)

    def _repr_html_(self) -> str:
        from palpate.grid.export import html_rows

        return html_rows(self)


def depth_text(depth_mm: float) -> str:
    """Depth (mm) as part of a column's name, exact to 1e-6 mm: 2.4 is ``"2_4"``, 8 is ``"8_0"``."""
    whole, _, part = f"{depth_mm:.6f}".partition(".")
    return f"{whole}_{part.rstrip('0') or '0'}"


def unit_of(column: str) -> str:
    """Unit of a column by its suffix; empty for a pure number or a word."""
    return next((unit for suffix, unit in UNITS.items() if column.endswith(suffix)), "")


def depth_of(column: str) -> tuple[str, float] | None:
    """Figure and depth (mm) of a column by depth, ``rmse_at_2_4mm_deg`` gives ``("rmse_deg", 2.4)``; else `None`."""
    match = _AT_DEPTH.search(column)
    return (column.replace(match[0], ""), float(f"{match[1]}.{match[2]}")) if match else None


def tilts_of(column: str) -> tuple[str, float, float] | None:
    """Figure and interval of tilt (degrees) of a column such as ``rmse_at_tilt_0_to_2_deg``; else `None`."""
    match = _AT_TILT.search(column)
    return (column.replace(match[0], ""), float(match[1]), float(match[2])) if match else None
