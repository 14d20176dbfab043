"""Report of an acceptance test as a page, a sheet and data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.core import wrap_write_errors
from palpate.core.report import Report
from palpate.sensor.accept import Acceptance, AcceptanceCheck
from palpate.sensor.report import provenance_line, write_report
from palpate.sensor.score import LEVEL, PAPER_TABLE_3

_A4 = (8.27, 11.69)
"""Size of a page, inches (ISO 216)."""
_CHECKS = ("figure", "value", f"{LEVEL:.0%} interval", "tolerance", "result")
_PAPER = "the paper's RMSE / MAE / max / SD"


def write_acceptance(folder: Path, found: Acceptance, title: str) -> None:
    """Write ``accept.json``, ``accept.md`` and ``accept.pdf`` into a folder.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    write_report(folder, "accept", {"unit": title, **found.as_dict()}, acceptance_page(found, title))
    with wrap_write_errors(folder, "Choose another folder."):
        draw_acceptance(found, title).savefig(folder / "accept.pdf")


def acceptance_page(found: Acceptance, title: str) -> list[str | Report]:
    """Return the report: verdict, tolerances, and errors next to those of the paper's sensor."""
    table = []
    for score in found.scores:
        errors, paper = score.errors, PAPER_TABLE_3[score.component]
        figures = (errors.rmse, errors.mae, errors.max, errors.sd, errors.bias)
        of_paper = " / ".join(f"{value:.2f}" for value in (paper.rmse, paper.mae, paper.max, paper.sd))
        table.append((f"{score.component} {score.unit}", *(f"{value:.3f}" for value in figures), of_paper))
    return [
        f"# Acceptance: {title}",
        f"**{verdict(found)}**",
        Report.of("", _CHECKS, map(_row, found.checks)),
        Report.of("", ("component", "RMSE", "MAE", "max", "SD", "bias", _PAPER), table, details=[_PAPER]),
        "\n".join(basis(found)),
        provenance_line(),
    ]


def verdict(found: Acceptance) -> str:
    """Return ``passed``, or the failed checks."""
    failed = [check.what for check in found.checks if not check.passed]
    return f"failed: {', '.join(failed)}" if failed else "passed"


def basis(found: Acceptance) -> list[str]:
    """Return sentences on the data of the figures."""
    lines = [
        f"{len(found.truth)} images of {len(np.unique(found.press))} presses, {found.spec.min_depth:g} mm deep or "
        f"more; {found.left_out} images left out; {found.flagged} of the evaluated readings are flagged.",
        "Intervals come from drawing whole presses with replacement; the maximum error has no interval."
        + (" Their upper ends must be within the tolerances." if found.spec.guard else ""),
    ]
    if found.zero:
        lines.append(
            f"The depth zero is at {found.zero.offset:.3f} mm on the robot's scale, by {found.zero.images} images "
            "of the first press, which is not evaluated."
        )
    return lines


def draw_acceptance(found: Acceptance, title: str) -> Figure:
    """Draw one sheet of A4: verdict, tolerances, and all errors over known pose and depth."""
    figure = Figure(figsize=_A4, layout="constrained")
    rows = len(found.scores)
    top, bottom = np.asarray(figure.subfigures(2, 1, height_ratios=[0.8, rows]))
    axis = top.subplots()
    axis.axis("off")
    axis.set_title(f"{title}: {verdict(found)}", loc="left", fontsize=13, wrap=True)
    cells = [list(_row(check)) for check in found.checks]
    drawn = axis.table(
        cellText=cells,
        colLabels=list(_CHECKS),
        loc="center",
        cellLoc="left",
        edges="horizontal",
    )
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(9)
    top.supxlabel("\n".join(basis(found)), fontsize=8, x=0.01, ha="left", wrap=True)
    axes = np.atleast_2d(bottom.subplots(rows, 2, sharey="row"))
    errors = found.estimates - found.truth
    for column, (score, pair) in enumerate(zip(found.scores, axes, strict=True)):
        _scatter(pair[0], found.truth[:, column], errors[:, column], f"{score.component} ({score.unit})")
        _scatter(pair[1], found.truth[:, 2], errors[:, column], "depth (mm)")
        pair[0].set_ylabel(f"error of {score.component} ({score.unit})")
    return figure


def _scatter(axis: Axes, truth: np.ndarray, error: np.ndarray, name: str) -> None:
    axis.plot(truth, error, ".", markersize=4, alpha=0.6)
    axis.axhline(0.0, color="0.6", linewidth=0.8)
    axis.set_xlabel(name)
    axis.spines[["top", "right"]].set_visible(False)


def _row(check: AcceptanceCheck) -> tuple[str, str, str, str, str]:
    unit = "" if check.unit == "1" else f" {check.unit}"
    interval = f"{check.interval[0]:.3f} to {check.interval[1]:.3f}" if check.interval else ""
    result = "within" if check.passed else "OUTSIDE"
    return check.what, f"{check.value:.3f}{unit}", interval, f"{check.limit:g}{unit}", result
