"""Tables of scores, for pages and for other programs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from palpate.core.report import Column, Report
from palpate_benchmark.score import BenchmarkScore, ScoreLine

_FIGURES = {"angle": "°", "depth": " mm", "force": " N"}
SCORE_COLUMNS = (
    "by",
    "name",
    "images",
    *(
        f"{part} {figure}"
        for part in _FIGURES
        for figure in ("RMSE", "max", "95th percentile", "in interval", "half-width")
    ),
)
_DETAILS = ("depth maximum", "force RMSE", "angle in interval", "angle maximum")
_COMPARED = (
    *("track", "images", "angle RMSE", "angle maximum", "95th percentile", "worst unit", "depth RMSE"),
    *("depth maximum", "force RMSE", "angle in interval"),
)


def score_rows(score: BenchmarkScore) -> list[list[str]]:
    """Return one row per group, by `SCORE_COLUMNS`; cells are empty if a quantity was not predicted."""
    return [_row(line) for line in score.lines]


def score_report(title: str, score: BenchmarkScore) -> Report:
    """Return the scores of one method, one row per group; columns of intervals are details."""
    details = [name for name in SCORE_COLUMNS if name.endswith(("in interval", "half-width"))]
    return Report.of(title, SCORE_COLUMNS, score_rows(score), details=details)


def compare_report(scores: Mapping[str, Iterable[BenchmarkScore]]) -> Report:
    """Return the scores of several methods, one row per method and track."""
    rows = [_compare(name, score) for name, own in scores.items() for score in own]
    return Report.of("", (Column("method", prose=True), *_COMPARED), rows, details=_DETAILS)


def _compare(name: str, score: BenchmarkScore) -> list[str]:
    every = score.all
    angle, depth, force = every.parts["angle"], every.parts["depth"], every.parts.get("force")
    return [
        name,
        score.track,
        str(every.images),
        f"{angle.rmse:.3f}°",
        f"{angle.max:.2f}°",
        f"{angle.p95:.3f}°",
        f"{score.worst_unit_p95_deg:.3f}°",
        f"{depth.rmse:.3f} mm",
        f"{depth.max:.2f} mm",
        f"{force.rmse:.3f} N" if force else "",
        "" if math.isnan(angle.coverage) else f"{angle.coverage:.1%}",
    ]


def _row(line: ScoreLine) -> list[str]:
    cells = [line.by, line.name, str(line.images)]
    for part in _FIGURES:
        found = line.parts.get(part)
        if found is None:
            cells += [""] * 5
            continue
        cells += [f"{value:.4f}" for value in (found.rmse, found.max, found.p95)]
        cells += ["" if math.isnan(value) else f"{value:.4f}" for value in (found.coverage, found.half_width)]
    return cells
