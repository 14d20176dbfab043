"""Grid: the specification grid of a study, its questions and its pictures."""

from palpate.grid.compare import METRICS, Comparison, Difference, compare_grids
from palpate.grid.draw import write_picture
from palpate.grid.evaluate_grid import evaluate_grid
from palpate.grid.export import export_grid, html_rows
from palpate.grid.grid import MAIN_COLUMNS, Cell, Row, SpecificationGrid, name_row, rows_of, unit_of
from palpate.grid.io import is_grid, read_grid, write_grid
from palpate.grid.model import copy_model
from palpate.grid.panel import CurvePanel, Panel, cut_depth_panels, cut_marker_panels, cut_panels, cut_tilt_panels
from palpate.grid.plot import KINDS, draw_grid, draw_plot, first_metric, name_plot, plot_grid, refuse_unknown
from palpate.grid.query import filter_rows, sort_rows

__all__ = [
    "KINDS",
    "MAIN_COLUMNS",
    "METRICS",
    "Cell",
    "Comparison",
    "CurvePanel",
    "Difference",
    "Panel",
    "Row",
    "SpecificationGrid",
    "compare_grids",
    "copy_model",
    "cut_depth_panels",
    "cut_marker_panels",
    "cut_panels",
    "cut_tilt_panels",
    "draw_grid",
    "draw_plot",
    "evaluate_grid",
    "export_grid",
    "filter_rows",
    "first_metric",
    "html_rows",
    "is_grid",
    "name_plot",
    "name_row",
    "plot_grid",
    "read_grid",
    "refuse_unknown",
    "rows_of",
    "sort_rows",
    "unit_of",
    "write_grid",
    "write_picture",
]
