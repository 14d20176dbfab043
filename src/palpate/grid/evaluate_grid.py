"""From what a study leaves behind to the specification grid."""

from __future__ import annotations

import json
import math
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence

from palpate.grid.grid import Cell, SpecificationGrid, depth_text
from palpate.learn import Coverage, Metrics, compare_with_limit, pool_limits
from palpate.study import DesignResult, PressSummary


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


_LAST = (
    "seed",
    "dataset_seed",
    "learning_seed",
    "versions",
    "spec",
    *(f"{kind}_key" for kind in ("press", "dataset", "limit", "estimator", "learning")),
    "failure",
)


def _row(design: DesignResult) -> dict[str, Cell]:
    return {
        "height_mm": design.dome.height,
        "base_radius_mm": design.dome.base_radius,
        "thickness_mm": design.dome.thickness,
        "shape": str(design.shape),
        "markers": design.markers.count,
        **_errors(design.clean, ""),
        **_errors(design.jittered, "_jitter"),
        **_spread(design),
        **_limits(design),
        **_coverage(design.coverage),
        "travel_mm": _finite(design.travel_mm),
        "peak_stress_mpa": _finite(design.peak_stress_mpa),
        **_presses(design.presses),
        "force_n": _finite(design.force_n),
        "bistable_from_mm": _finite(design.bistable_from_mm),
        **_evidence(design),
        **_details(design.clean, ""),
        **_details(design.jittered, "_jitter"),
        "seed": design.seed,
        **{f"{stage}_seed": design.spec.get(stage, {}).get("seed") for stage in ("dataset", "learning")},
        "versions": " ".join(f"{name}={version}" for name, version in sorted(design.versions.items())),
        "spec": json.dumps(design.spec, sort_keys=True),
        **{f"{kind}_key": " ".join(keys) for kind, keys in design.artefacts.items()},
        "failure": design.failure,
    }


def _errors(metrics: Metrics | None, suffix: str) -> dict[str, Cell]:
    return {
        f"rmse{suffix}_deg": metrics.angle.rmse if metrics else None,
        f"max_error{suffix}_deg": metrics.angle.max if metrics else None,
    }


def _spread(design: DesignResult) -> dict[str, Cell]:
    """Standard deviation of the clean RMSE over the repeats, which takes two."""
    repeats = design.repeat_rmse_deg
    return {
        "rmse_spread_deg": statistics.stdev(repeats) if len(repeats) > 1 else None,
        "repeats": len(repeats) or None,
    }


def _limits(design: DesignResult) -> dict[str, Cell]:
    """Bounds on the jittered RMSE and how near it comes, over all depths and by depth."""
    judged = compare_with_limit(design.jittered, design.limits) if design.jittered else None
    pooled = judged[0] if judged else pool_limits(design.limits)
    found: dict[str, Cell] = {
        "limit_deg": pooled.least_squares_deg if pooled else None,
        "limit_pitman_deg": pooled.pitman_deg if pooled else None,
        "rmse_over_limit": judged[1] if judged else None,
    }
    by_depth = design.jittered.by_depth if design.jittered else ()
    rmse = {depth_text(errors.depth_mm): errors.angle.rmse for errors in by_depth}
    for limit in design.limits:
        depth = depth_text(limit.depth_mm)
        found[f"limit_at_{depth}mm_deg"] = limit.least_squares_deg
        found[f"limit_pitman_at_{depth}mm_deg"] = limit.pitman_deg
        found[f"limit_floor_at_{depth}mm_deg"] = limit.floor_deg
        if depth in rmse and limit.least_squares_deg > 0:
            found[f"rmse_over_limit_at_{depth}mm"] = rmse[depth] / limit.least_squares_deg
    return found


def _coverage(coverage: Coverage | None) -> dict[str, Cell]:
    """What the intervals are worth on presses that did not calibrate them."""
    return {
        "interval_level": coverage.level if coverage else None,
        "interval_coverage": coverage.angle if coverage else None,
        "interval_coverage_depth": coverage.depth if coverage else None,
        "interval_half_width_deg": coverage.half_width_deg if coverage else None,
        "interval_half_width_mm": coverage.half_width_mm if coverage else None,
        "interval_presses": coverage.presses if coverage else None,
        "called_outside": coverage.outside if coverage else None,
    }


def _details(metrics: Metrics | None, suffix: str) -> dict[str, Cell]:
    """Every summary figure per axis, and RMSE and maximum of the angle by depth and by tilt."""
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
        found[f"validation_samples_at_{depth}"] = errors.images
    for part in metrics.by_tilt:
        tilts = f"tilt_{part.from_deg:g}_to_{part.to_deg:g}"
        found[f"rmse_at_{tilts}{suffix}_deg"] = part.angle.rmse
        found[f"max_error_at_{tilts}{suffix}_deg"] = part.angle.max
        found[f"validation_samples_at_{tilts}"] = part.images
    return found


def _presses(presses: Sequence[PressSummary]) -> dict[str, Cell]:
    """How the dome deforms: in the press of least tilt, and at worst over all presses."""
    straight = min(presses, key=lambda press: press.tilt_deg) if presses else None
    return {
        "peak_stress_straight_mpa": straight.peak_stress_mpa if straight else None,
        "displacement_max_straight_mm": straight.displacement_max_mm if straight else None,
        "displacement_mean_straight_mm": straight.displacement_mean_mm if straight else None,
        "displacement_max_mm": max((press.displacement_max_mm for press in presses), default=None),
        "apex_gap_mm": max((press.apex_gap_mm for press in presses), default=None),
        "branch_by_tilt": "; ".join(f"{press.tilt_deg:g}: {press.branch}" for press in presses),
        "depth_by_tilt_mm": "; ".join(f"{press.tilt_deg:g}: {press.ended_depth_mm:.2f}" for press in presses),
    }


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
