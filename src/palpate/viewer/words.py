"""Names of columns and figures as people read them."""

from __future__ import annotations

import json

from palpate.grid import Cell, SpecificationGrid, column_unit

_NAMES = {
    "built_rmse_deg": "RMSE of the angle as built",
    "built_p95_deg": "greatest error as built",
    "calibrated_rmse_deg": "RMSE after known presses",
    "calibrated_p95_deg": "greatest error after known presses",
    "rmse_deg": "RMSE of the angle",
    "max_error_deg": "greatest error of the angle",
    "rmse_jitter_deg": "RMSE of the angle with jitter",
    "max_error_jitter_deg": "greatest error with jitter",
    "bound_deg": "limit of any network",
    "rmse_over_bound": "RMSE over its limit",
    "travel_mm": "marker travel",
    "force_n": "force at full depth",
    "peak_stress_mpa": "peak stress",
    "bistable_from_mm": "second state from",
    "interval_coverage": "coverage of the intervals",
    "interval_half_width_deg": "half-width of the interval",
    "rmse_depth_mm": "RMSE of the depth",
    "height_mm": "height H",
    "thickness_mm": "thickness T",
    "base_radius_mm": "base radius B",
    "p95_deg": "error of 19 of 20 units",
    "coarse_p95_deg": "the same by coarse presses",
    "size_mm": "outer diameter",
    "max_depth_mm": "depth reached",
    "distance_mm": "camera below the base",
    "marker_diameter_mm": "diameter of a dot",
    "ring_diameters_mm": "diameters of the rings",
    "feasible": "within the limits",
}


def column_name(column: str) -> str:
    """A column without its unit, e.g. ``"marker travel"``."""
    unit = column_unit(column)
    short = column.removesuffix(f"_{unit.lower()}") if unit else column
    return _NAMES.get(column, short.replace("_", " ").replace("rmse", "RMSE"))


def column_label(column: str) -> str:
    """A column with its unit, e.g. ``"marker travel (mm)"``."""
    unit = column_unit(column)
    return column_name(column) + (f" ({'°' if unit == 'deg' else unit})" if unit else "")


def jitter_words(grid: SpecificationGrid) -> str:
    """How far the pixels of a grid's studies were moved for the errors with jitter, e.g. ``"2 px jitter"``."""
    specs = (json.loads(str(row.get("spec") or "{}")) for row in grid.designs)
    found = {spec["dataset"]["jitter_px"] for spec in specs if "jitter_px" in spec.get("dataset", {})}
    return f"{' or '.join(f'{value:g}' for value in sorted(found))} px jitter" if found else "jitter"


def format_cell(cell: Cell) -> str:
    """A cell in about three digits; a dash for an empty one."""
    if cell is None or cell == "":
        return "–"
    return cell if isinstance(cell, str) else f"{cell:.3g}"
