"""Columns of the grid: heading, unit, digits and meaning, for tables, figures, files and the viewer."""

from __future__ import annotations

from palpate.core.report import Column

_WORDS = """
height_mm | height | Height of the apex over the base
base_radius_mm | base radius | Radius of the base
thickness_mm | thickness | Skin thickness
shape | shape | Shape of the skin
markers | markers | Number of markers
built_rmse_deg | angle RMSE as built | RMSE of the contact angle, built units
built_p95_deg | 95th percentile as built | 95th percentile over built units of the maximum angle error
calibrated_rmse_deg | angle RMSE, calibrated | RMSE of the contact angle, calibrated units
calibrated_p95_deg | 95th percentile, calibrated | 95th percentile over calibrated units of the maximum angle error
rmse_jitter_deg | angle RMSE with jitter | RMSE of the contact angle, jittered images
max_error_jitter_deg | maximum angle error with jitter | Maximum error of the contact angle, jittered images
rmse_deg | angle RMSE | RMSE of the contact angle, clean images
max_error_deg | maximum angle error | Maximum error of the contact angle, clean images
rmse_jitter_mm | offset RMSE with jitter | RMSE of the offset, jittered images
max_error_jitter_mm | maximum offset error with jitter | Maximum error of the offset, jittered images
rmse_mm | offset RMSE | RMSE of the offset, clean images
max_error_mm | maximum offset error | Maximum error of the offset, clean images
rmse_spread_deg | RMSE spread | Standard deviation of the RMSE over the repeats, clean images
rmse_depth_mm | depth RMSE | RMSE of the depth, clean images
bound_deg | least-squares bound | Least-squares bound of the contact angle, jittered images
bound_mm | least-squares bound | Least-squares bound of the offset, jittered images
bound_pitman_deg | Pitman bound | Pitman bound of the contact angle, jittered images
bound_floor_deg | bound of any estimator | Bound of any estimator of the contact angle, jittered images
rmse_over_bound | RMSE over least-squares bound | RMSE over the least-squares bound, jittered images
interval_coverage | interval coverage | Share of true angles inside their interval, jittered images
interval_half_width_deg | interval half-width | Mean half-width of the interval, jittered images
travel_mm | marker travel | Mean marker travel from rest at the maximum depth
displacement_mean_straight_mm | mean displacement | Mean displacement of the skin, straight press
peak_stress_mpa | peak stress | Maximum von Mises stress, all presses
peak_stress_straight_mpa | peak stress, straight press | Maximum von Mises stress, straight press
force_n | force at full depth | Contact force at full depth, straight press
bistable_from_mm | bistable from | Depth from which a second stable state exists
presses | presses | Number of presses
presses_inverted | inverted presses | Number of presses of the inverted branch
samples | samples | Number of images in the dataset
dropped | dropped images | Number of images that were left out
ended | ended | Reasons why presses ended, with their number
seed | seed | Seed of the study
failure | failure | Reason why figures are missing
"""
"""Name, heading and meaning of each column, in the order of the tables."""
_DECIDING = {
    *("height_mm", "thickness_mm", "markers", "built_rmse_deg", "built_p95_deg"),
    *("calibrated_rmse_deg", "calibrated_p95_deg", "rmse_jitter_deg", "rmse_jitter_mm"),
}
_FORMS = {"peak_stress_mpa": ".4f", "peak_stress_straight_mpa": ".4f"}
_COLUMNS = {
    name: Column(name, heading, None, _FORMS.get(name, ""), meaning, name in _DECIDING, name == "failure")
    for name, heading, meaning in (line.split(" | ") for line in _WORDS.split("\n") if line)
}
_DETAILS = (
    *("base_radius_mm", "shape", "rmse_depth_mm", "bound_pitman_deg", "interval_half_width_deg"),
    *("peak_stress_straight_mpa", "presses", "presses_inverted", "dropped", "ended", "seed", "failure"),
)
_CURVES = ("bound_floor_deg", "displacement_mean_straight_mm")
MAIN_COLUMNS = tuple(name for name in _COLUMNS if name not in (*_DETAILS, *_CURVES))
"""Names of the main columns."""
CSV_COLUMNS = tuple(name for name in _COLUMNS if name not in _CURVES)
"""Columns of a design in CSV, behind its name. SQLite, JSON and Parquet have all."""


def grid_column(name: str) -> Column:
    """Return the column of a name, with a heading from the name if the table lacks it.

    Examples
    --------
    >>> grid_column("travel_mm").label, grid_column("rmse_rx_deg").label
    ('marker travel (mm)', 'RMSE rx (°)')
    """
    return _COLUMNS.get(name) or Column(name, deciding=False)
