"""The noun of the stage: one row of figures a design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Cell = float | int | str | None
"""A figure, a word, or nothing where the chain broke or the figure does not apply."""

Row = Mapping[str, Cell]

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
    held-out presses; ``_jitter`` is the same with jittered pixels. ``rmse_rx_deg``, …, ``bias_ry_deg`` and
    ``rmse_depth_mm`` are per axis, ``rmse_at_2_4mm_deg``, … per depth (here 2.4 mm). ``travel_mm`` is the
    distance in space of a marker from rest, as mean over the markers and over the sampled poses at the greatest
    depth. ``peak_stress_mpa`` is the greatest von Mises stress in any image of any press, ``force_n`` the wall's
    force in the deepest image of the press of least tilt.
    """

    rows: tuple[Row, ...]
    columns: tuple[str, ...]

    def __post_init__(self) -> None:
        for row in self.rows:
            if tuple(row) != self.columns:
                raise ValueError(f"row {dict(row)} does not have the columns {self.columns}")


def depth_text(depth_mm: float) -> str:
    """Depth (mm) as part of a column's name, exact to 1e-6 mm: 2.4 is ``"2_4"``, 8 is ``"8_0"``."""
    whole, _, part = f"{depth_mm:.6f}".partition(".")
    return f"{whole}_{part.rstrip('0') or '0'}"


def unit_of(column: str) -> str:
    """Unit of a column by its suffix; empty for a pure number or a word."""
    return next((unit for suffix, unit in UNITS.items() if column.endswith(suffix)), "")
