"""Grid: the specification grid of a study, its questions and its pictures."""

from palpate.grid.columns import MAIN_COLUMNS, grid_column
from palpate.grid.compare import Comparison, Difference, compare_grids
from palpate.grid.draw import write_picture
from palpate.grid.evaluate_grid import evaluate_grid
from palpate.grid.export import export_grid, grid_report, html_rows
from palpate.grid.grid import Cell, Row, SpecificationGrid, design_label, design_spec, own_column, rows_for_design
from palpate.grid.io import is_grid, read_grid, write_grid
from palpate.grid.model import copy_model
from palpate.grid.panel import CurvePanel, Panel, cut_depth_panels, cut_marker_panels, cut_panels, cut_tilt_panels
from palpate.grid.plot import (
    check_plot_request,
    default_metric,
    draw_grid,
    draw_plot,
    plot_file_name,
    plot_grid,
)
from palpate.grid.query import filter_rows, sort_rows

__all__ = [
    "MAIN_COLUMNS",
    "Cell",
    "Comparison",
    "CurvePanel",
    "Difference",
    "Panel",
    "Row",
    "SpecificationGrid",
    "check_plot_request",
    "compare_grids",
    "copy_model",
    "cut_depth_panels",
    "cut_marker_panels",
    "cut_panels",
    "cut_tilt_panels",
    "default_metric",
    "design_label",
    "design_spec",
    "draw_grid",
    "draw_plot",
    "evaluate_grid",
    "export_grid",
    "filter_rows",
    "grid_column",
    "grid_report",
    "html_rows",
    "is_grid",
    "own_column",
    "plot_file_name",
    "plot_grid",
    "read_grid",
    "rows_for_design",
    "sort_rows",
    "write_grid",
    "write_picture",
]
