"""Grid: the specification grid of a study, its questions and its pictures."""

from palpate.grid.claim import Answer, Claim, Finding, Verdict
from palpate.grid.compare import METRICS, Comparison, Difference, compare_grids
from palpate.grid.evaluate_claims import evaluate_claims, read_evidence
from palpate.grid.evaluate_grid import evaluate_grid
from palpate.grid.evidence import Evidence
from palpate.grid.export import export_grid, html_rows
from palpate.grid.grid import MAIN_COLUMNS, Cell, Row, SpecificationGrid, name_row, rows_of, unit_of
from palpate.grid.io import read_grid, write_grid
from palpate.grid.model import copy_model
from palpate.grid.panel import (
    CurvePanel,
    Panel,
    cut_depth_panels,
    cut_marker_panels,
    cut_panels,
    cut_tilt_panels,
)
from palpate.grid.plot import KINDS, draw_grid, plot_grid
from palpate.grid.query import filter_rows, sort_rows
from palpate.grid.write_claims import write_claims

__all__ = [
    "KINDS",
    "MAIN_COLUMNS",
    "METRICS",
    "Answer",
    "Cell",
    "Claim",
    "Comparison",
    "CurvePanel",
    "Difference",
    "Evidence",
    "Finding",
    "Panel",
    "Row",
    "SpecificationGrid",
    "Verdict",
    "compare_grids",
    "copy_model",
    "cut_depth_panels",
    "cut_marker_panels",
    "cut_panels",
    "cut_tilt_panels",
    "draw_grid",
    "evaluate_claims",
    "evaluate_grid",
    "export_grid",
    "filter_rows",
    "html_rows",
    "name_row",
    "plot_grid",
    "read_evidence",
    "read_grid",
    "rows_of",
    "sort_rows",
    "unit_of",
    "write_claims",
    "write_grid",
]
