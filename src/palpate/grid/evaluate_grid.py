"""From what a study leaves behind to the specification grid."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from palpate.grid.grid import Cell, SpecificationGrid, depth_text
from palpate.learn import Metrics
from palpate.study import DesignResult


def evaluate_grid(designs: Sequence[DesignResult]) -> SpecificationGrid:
    """Put one row of figures a design together.

    Parameters
    ----------
    designs
        Records of a study.

    Returns
    -------
    SpecificationGrid
        A row for every design, also for one whose chain broke: its figures are empty, `failure` says why.
    """
    rows = [_row(design) for design in designs]
    columns = tuple(dict.fromkeys(name for row in rows for name in row))
    columns = (*(name for name in columns if name not in _LAST), *(name for name in columns if name in _LAST))
    return SpecificationGrid(rows=tuple({name: row.get(name) for name in columns} for row in rows), columns=columns)


_LAST = ("seed", "versions", "press_key", "dataset_key", "learning_key", "failure")


def _row(design: DesignResult) -> dict[str, Cell]:
    return {
        "height_mm": design.dome.height,
        "base_radius_mm": design.dome.base_radius,
        "thickness_mm": design.dome.thickness,
        "shape": str(design.shape),
        "markers": design.markers.count,
        **_errors(design.clean, ""),
        **_errors(design.jittered, "_jitter"),
        "travel_mm": _finite(design.travel_mm),
        "peak_stress_mpa": _finite(design.peak_stress_mpa),
        "force_n": _finite(design.force_n),
        **_evidence(design),
        **_details(design.clean, ""),
        **_details(design.jittered, "_jitter"),
        "seed": design.seed,
        "versions": " ".join(f"{name}={version}" for name, version in sorted(design.versions.items())),
        **{f"{kind}_key": " ".join(keys) for kind, keys in design.artefacts.items()},
        "failure": design.failure,
    }


def _errors(metrics: Metrics | None, suffix: str) -> dict[str, Cell]:
    return {
        f"rmse{suffix}_deg": metrics.angle.rmse if metrics else None,
        f"max_error{suffix}_deg": metrics.angle.max if metrics else None,
    }


def _details(metrics: Metrics | None, suffix: str) -> dict[str, Cell]:
    """Every summary figure per axis, and RMSE and maximum of the angle by depth."""
    if metrics is None:
        return {}
    found: dict[str, Cell] = {}
    axes = (("angle", metrics.angle, "deg"), ("rx", metrics.rx, "deg"), ("ry", metrics.ry, "deg"))
    for axis, summary, unit in (*axes, ("depth", metrics.depth, "mm")):
        for figure in ("rmse", "mae", "max", "sd", "bias"):
            if axis == "angle" and figure in ("rmse", "max"):
                continue  # these two are the grid's main columns
            found[f"{figure}_{axis}{suffix}_{unit}"] = getattr(summary, figure)
    for errors in metrics.by_depth:
        depth = f"{depth_text(errors.depth_mm)}mm"
        found[f"rmse_at_{depth}{suffix}_deg"] = errors.angle.rmse
        found[f"max_error_at_{depth}{suffix}_deg"] = errors.angle.max
    return found


def _evidence(design: DesignResult) -> dict[str, Cell]:
    """How many presses, images and dropped poses stand behind the figures, and on which branch the presses end."""
    counts = design.counts
    branches = Counter(press.branch for press in design.presses)
    ends = Counter(press.ended for press in design.presses)
    return {
        "presses": counts.presses if counts else len(design.presses),
        "virtual_presses": counts.virtual_presses if counts else None,
        "samples": counts.samples if counts else None,
        "validation_samples": counts.validation_samples if counts else None,
        "dropped": sum(counts.dropped.values()) if counts else None,
        "dropped_reasons": _tally(counts.dropped) if counts else None,
        "presses_flat": branches["flat"],
        "presses_inverted": branches["inverted"],
        "ended": _tally(ends),
    }


def _tally(counts: Mapping[str, int]) -> str:
    return "; ".join(f"{reason}: {count}" for reason, count in sorted(counts.items()))


def _finite(value: float) -> Cell:
    return value if math.isfinite(value) else None
