"""Grid: the specification grid of a study, its questions and its pictures."""

from palpate.grid.evaluate_grid import evaluate_grid
from palpate.grid.grid import Cell, Row, SpecificationGrid, unit_of
from palpate.grid.io import read_grid, write_grid
from palpate.grid.panel import DepthPanel, Panel, cut_depth_panels, cut_panels
from palpate.grid.query import filter_rows, sort_rows

__all__ = [
    "Cell",
    "DepthPanel",
    "Panel",
    "Row",
    "SpecificationGrid",
    "cut_depth_panels",
    "cut_panels",
    "evaluate_grid",
    "filter_rows",
    "read_grid",
    "sort_rows",
    "unit_of",
    "write_grid",
]
