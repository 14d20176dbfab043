"""The error budget as files: a table for people and programs, and a bar chart."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from palpate.bench.bench import BENCH_VERSION, Bench
from palpate.bench.budget import BudgetLine, recommend, total
from palpate.core import provenance, writing

BUDGET_COLUMNS = ("imperfection", "tolerance", "angle RMS deg", "angle max deg", "depth RMS mm", "units")


def describe_budget(bench: Bench, lines: Sequence[BudgetLine]) -> dict[str, Any]:
    """The budget as JSON data."""
    return {
        "spec": bench.spec.model_dump(mode="json"),
        "dome": bench.dome.model_dump(mode="json"),
        "markers": len(bench.layout),
        "model_sha256": bench.model_sha256,
        "made_by": provenance() | {"bench": BENCH_VERSION},
        "lines": [line.as_dict() for line in lines],
        "total_angle_deg": total(lines),
        "recommended": recommend(lines, bench.spec.tolerance),
    }


def write_budget(folder: Path, bench: Bench, lines: Sequence[BudgetLine]) -> None:
    """Write ``budget.json``, ``budget.csv``, ``budget.md`` and ``budget.png`` into a folder.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    with writing(folder, "Choose another folder."):
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(describe_budget(bench, lines), indent=2).replace("NaN", "null")
        (folder / "budget.json").write_text(text + "\n", encoding="utf-8")
        (folder / "budget.md").write_text(budget_page(bench, lines), encoding="utf-8")
        with (folder / "budget.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([BUDGET_COLUMNS, *map(budget_row, lines)])
        draw_budget(lines).savefig(folder / "budget.png", dpi=150)


def budget_row(line: BudgetLine) -> list[str]:
    """A line of the table by `BUDGET_COLUMNS`."""
    figures = (line.angle_deg, line.angle_max_deg, line.depth)
    return [line.words, line.tolerance, *(f"{value:.3f}" for value in figures), str(line.units)]


def budget_page(bench: Bench, lines: Sequence[BudgetLine]) -> str:
    """The budget as a Markdown page."""
    rows = [BUDGET_COLUMNS, ["---"] * len(BUDGET_COLUMNS), *map(budget_row, lines)]
    advice = recommend(lines, bench.spec.tolerance)
    return "\n".join(
        [
            f"# Error budget: H {bench.dome.height:g}, T {bench.dome.thickness:g} mm, {len(bench.layout)} markers",
            "",
            "Each imperfection alone at its tolerance; how much it changes the readings of the same poses. Model "
            f"{bench.model_sha256[:12]}, seed {bench.spec.seed}.",
            "",
            *(f"| {' | '.join(row)} |" for row in rows),
            "",
            f"All at once, as root of the sum of squares: {total(lines):.3f}°.",
            "",
            "![budget](budget.png)",
            "",
            "## Recommended randomisation of the training",
            "",
            *(f"* `{name}: {value:g}`" for name, value in advice.items()),
            *([] if advice else ["None: nothing that a training could see costs more than the model itself."]),
            *[f"\n{line.words}: {failure}" for line in lines for failure in line.failures],
            "",
        ]
    )


def draw_budget(lines: Sequence[BudgetLine]) -> Figure:
    """Bar chart of the degrees that each imperfection costs, the dearest at the top."""
    shown = sorted((line for line in lines if np.isfinite(line.angle_deg)), key=lambda line: line.angle_deg)
    figure = Figure(figsize=(7.0, 0.8 + 0.3 * len(shown)), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    places = np.arange(len(shown))
    axis.barh(places, [line.angle_max_deg for line in shown], color="0.85", label="greatest")
    axis.barh(places, [line.angle_deg for line in shown], color="C0", label="root mean square")
    axis.set_yticks(places, [f"{line.words} {line.tolerance}".strip() for line in shown])
    axis.set_xlabel("change of rx and ry (degrees)")
    axis.legend(frameon=False, loc="lower right")
    axis.spines[["top", "right"]].set_visible(False)
    return figure
