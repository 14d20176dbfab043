"""Error budget as files: tables as Markdown, CSV and JSON, and a bar chart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from palpate.core import wrap_write_errors
from palpate.core.report import Report
from palpate.sensor import write_report
from palpate.simulation.budget import BudgetLine, recommend_randomisation, total
from palpate.simulation.run_trial import VirtualBench

BUDGET_COLUMNS = ("imperfection", "tolerance", "angle RMS deg", "angle max deg", "depth RMS mm", "units")


def describe_budget(bench: VirtualBench, lines: Sequence[BudgetLine]) -> dict[str, Any]:
    """Return the budget as JSON data."""
    return {
        **bench.facts(),
        "lines": [line.as_dict() for line in lines],
        "total_angle_deg": total(lines),
        "recommended": recommend_randomisation(lines, bench.spec.tolerance),
    }


def write_budget(folder: Path, bench: VirtualBench, lines: Sequence[BudgetLine]) -> None:
    """Write ``budget.json``, ``budget.csv``, ``budget.md`` and ``budget.png`` into a folder.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    table = [BUDGET_COLUMNS, *map(budget_row, lines)]
    write_report(folder, "budget", describe_budget(bench, lines), budget_page(bench, lines), table)
    with wrap_write_errors(folder, "Choose another folder."):
        draw_budget(lines).savefig(folder / "budget.png", dpi=150)


def budget_row(line: BudgetLine) -> list[str]:
    """Return a line of the table by `BUDGET_COLUMNS`."""
    figures = (line.angle_deg, line.angle_max_deg, line.depth)
    return [line.label, line.tolerance, *(f"{value:.3f}" for value in figures), str(line.units)]


def budget_page(bench: VirtualBench, lines: Sequence[BudgetLine]) -> list[str | Report]:
    """Return paragraphs and tables of the budget."""
    advice = recommend_randomisation(lines, bench.spec.tolerance)
    return [
        f"# Error budget: {bench.name}",
        "Each imperfection alone at its tolerance; the change of the readings of the same poses. Model "
        f"{bench.model_sha256[:12]}, seed {bench.spec.seed}.",
        Report.of("", BUDGET_COLUMNS, map(budget_row, lines)),
        f"All at once, as root of the sum of squares: {total(lines):.3f}°.",
        "![budget](budget.png)",
        "## Recommended randomisation of the training",
        "\n".join(f"* `{name}: {value:g}`" for name, value in advice.items())
        or "None: nothing that a training could see costs more than the model itself.",
        *[f"{line.label}: {failure}" for line in lines for failure in line.failures],
    ]


def draw_budget(lines: Sequence[BudgetLine]) -> Figure:
    """Draw the cost of each imperfection as a bar chart, in descending order."""
    shown = sorted((line for line in lines if np.isfinite(line.angle_deg)), key=lambda line: line.angle_deg)
    figure = Figure(figsize=(7.0, 0.8 + 0.3 * len(shown)), layout="constrained")
    axis = figure.subplots()
    places = np.arange(len(shown))
    axis.barh(places, [line.angle_max_deg for line in shown], color="0.85", label="greatest")
    axis.barh(places, [line.angle_deg for line in shown], color="C0", label="root mean square")
    axis.set_yticks(places, [f"{line.label} {line.tolerance}".strip() for line in shown])
    axis.set_xlabel("change of rx and ry (degrees)")
    axis.legend(frameon=False, loc="lower right")
    axis.spines[["top", "right"]].set_visible(False)
    return figure
