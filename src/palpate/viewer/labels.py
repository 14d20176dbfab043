"""Headings of the columns of a search, and the jitter of a grid."""

from __future__ import annotations

from palpate.core.report import Column
from palpate.optimise import FRONT_COLUMNS
from palpate.study import SpecificationGrid, design_spec, grid_column


def find_column(name: str) -> Column:
    """Column of a search by its name, or else the column of the grid."""
    return next((column for column in FRONT_COLUMNS if column.name == name), None) or grid_column(name)


def column_label(name: str) -> str:
    """Heading of a column with its unit, e.g. ``"marker travel (mm)"``."""
    return find_column(name).label


def jitter_words(grid: SpecificationGrid) -> str:
    """Jitter of a grid's studies in the errors with jitter, as text, e.g. ``"2 px jitter"``."""
    specs = (design_spec(row) for row in grid.designs)
    found = {spec["dataset"]["jitter_px"] for spec in specs if "jitter_px" in spec.get("dataset", {})}
    return f"{' or '.join(f'{value:g}' for value in sorted(found))} px jitter" if found else "jitter"
