"""Curves of a design by depth: force, errors and error bounds."""

from __future__ import annotations

from collections.abc import Sequence

from palpate.study import Row, SpecificationGrid, own_column, rows_for_design
from palpate.viewer.charts import FIRST, LIMIT, SECOND, ChartCurve
from palpate.viewer.pressed_skin import SurfaceMotion
from palpate.viewer.results import GridDesign


def force_curves(shown: list[tuple[GridDesign, SurfaceMotion]]) -> tuple[list[ChartCurve], list[ChartCurve]]:
    """Force (N) over depth (mm) of one or two designs, a curve a branch, and where a second state begins."""
    curves, marks = [], []
    for (design, motion), colour in zip(shown, (FIRST, SECOND), strict=False):
        for branch in dict.fromkeys(motion.branch):
            points = [
                (float(depth), float(force))
                for depth, force, label in zip(motion.depths_mm, motion.force_n, motion.branch, strict=True)
                if label == branch
            ]
            name = branch if len(shown) == 1 else f"{_short(design)} {branch}"
            curves.append(ChartCurve(name, points, colour, dashed=branch != "flat"))
        start = design.row.get("bistable_from_mm")
        if isinstance(start, int | float):
            marks.append(ChartCurve(f"two states from {start:.2g} mm", [(float(start), 0.0)], colour, dashed=True))
    return curves, marks


def error_curves(grid: SpecificationGrid, shown: list[GridDesign]) -> list[ChartCurve]:
    """Jittered RMSE (degrees or mm) and least-squares bound by depth (mm) of one or two designs."""
    curves = []
    for design, colour in zip(shown, (FIRST, SECOND), strict=False):
        rows = rows_for_design(grid.by_depth, design.number)
        names = (own_column(rows[0] if rows else (), name) for name in ("rmse_jitter_deg", "bound_deg"))
        errors, limits = (_points(rows, name) for name in names)
        name = "" if len(shown) == 1 else f"{_short(design)} "
        if errors:
            curves.append(ChartCurve(f"{name}network", errors, colour))
        if limits:
            curves.append(
                ChartCurve(f"{name}least-squares bound", limits, colour if len(shown) > 1 else LIMIT, dashed=True)
            )
    return curves


def _short(design: GridDesign) -> str:
    return f"H{design.design.skin.height:g} T{design.design.skin.thickness:g} {len(design.design.layout)}"


def _points(rows: Sequence[Row], column: str) -> list[tuple[float, float]]:
    """Depth (mm) and figure of the rows that have it."""
    found = [(row["depth_mm"], row[column]) for row in rows]
    return [(float(depth), float(cell)) for depth, cell in found if depth is not None and cell is not None]
