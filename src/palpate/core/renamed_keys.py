"""Renamed keys of files: old keys of a spec are rejected, old columns of results are read until 0.4."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

_BENCH = {"image_step": "depth_step", "known": "calibration_presses", "least_depth": "min_depth"}
RENAMED_KEYS: dict[str, dict[str, str]] = {
    "AcceptanceSpec": {"least_depth": "min_depth"},
    "AlignSpec": {"most_touches": "max_touches", "least_depth": "min_depth", "looks": "max_image_retries"},
    "AsBuiltSpec": {"known": "calibration_presses"},
    "BenchmarkSpec": {"least_depth": "min_depth"},
    "CalibrationSpec": {"least_images": "min_images"},
    "DesignDraft": {"dome": "skin", "wall": "obstacle"},
    "FitSpec": {"largest_exponent": "max_exponent"},
    "ObstacleSpec": {"image_step": "depth_step"},
    "PrepareSpec": {"least_stretch": "min_stretch", "greatest_stretch": "max_stretch"},
    "ProcessSpec": {
        "smallest_dot": "min_marker_diameter",
        "smallest_gap": "min_gap",
        "steepest_deg": "max_slope_deg",
    },
    "RecordingSpec": {"held_out": "test_share", "validation": "validation_share", "most": "max_images"},
    "RequirementsSpec": {
        "known": "calibration_presses",
        "least_depth": "min_depth",
        "dot": "min_marker_diameter",
        "greatest_dot": "max_marker_diameter",
        "proof": "validation",
        "rival": "baseline",
        "control": "random_skins",
        "grid": "baseline_grid",
        "hours": "max_hours",
    },
    "SensorSpec": {"least_found": "min_found"},
    "SimulatedRobotSpec": {
        "place_mm": "position_sd_mm",
        "turn_deg": "rotation_sd_deg",
        "unreadable": "dropout",
    },
    "ToleranceSpec": {
        "pad": "print_shift",
        "dot": "marker_position",
        "touch": "depth_zero",
        "bend": "curvature",
        "friction": "friction_min",
        "friction_most": "friction_max",
    },
    "Study": {"wall": "obstacle", "side_wall": "obstacle: {kind: side_wall}"},
    "TwinPressSpec": {"image_step": "depth_step"},
    "VirtualBenchSpec": _BENCH,
    "WallSpec": {"bend": "curvature", "drift": "lateral_rate", "drift_across": "lateral_rate_across"},
}
"""Class of a spec → old key → new key; the old one is rejected (`yaml-key-renamed`)."""

RENAMED_COLUMNS = {
    "built_worst_deg": "built_p95_deg",
    "known_rmse_deg": "calibrated_rmse_deg",
    "known_worst_deg": "calibrated_p95_deg",
    "known_depth_rmse_mm": "calibrated_depth_rmse_mm",
    "known_presses": "calibration_presses",
    "limit_deg": "bound_deg",
    "limit_pitman_deg": "bound_pitman_deg",
    "limit_floor_deg": "bound_floor_deg",
    "rmse_over_limit": "rmse_over_bound",
    "called_outside": "flagged_ood",
    "worst_deg": "p95_deg",
    "coarse_worst_deg": "coarse_p95_deg",
    "reach_mm": "max_depth_mm",
    "twin_off_mm": "twin_error_mm",
    "dot_mm": "marker_diameter_mm",
    "meets": "feasible",
    "known": "calibration_presses",
    "slip": "inverse_friction",
    "left_deg": "residual_deg",
    "left_half_width_deg": "residual_half_width_deg",
    "ending": "outcome",
    "most_force_n": "max_force_n",
}
"""Old name of a result's column or JSON key → new name; old names are read, with a warning, until 0.4."""


def new_column(name: str, columns: Mapping[str, Any]) -> str:
    """Return the current name of a table's column; an old name gives a warning.

    Examples
    --------
    >>> new_column("rmse_deg", {"rmse_deg": 1.0})
    'rmse_deg'
    """
    new = RENAMED_COLUMNS.get(name, name)
    if name in columns or new not in columns:
        return name
    _warn([name])
    return new


def rename_columns(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of a result with the new names of its columns; old names give a warning."""
    old = [name for name in row if name in RENAMED_COLUMNS]
    if old:
        _warn(old)
    return {RENAMED_COLUMNS.get(name, name): value for name, value in row.items()}


def _warn(names: list[str]) -> None:
    said = ", ".join(f"{name} is {RENAMED_COLUMNS[name]} now" for name in names)
    warnings.warn(f"Old column names: {said}; 0.4.0 refuses them.", FutureWarning, stacklevel=3)
