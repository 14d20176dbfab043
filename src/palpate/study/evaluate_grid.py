"""Specification grid from the records of a study."""

from __future__ import annotations

import json
import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict

from palpate.calibration import PredictedAccuracy
from palpate.design import OFFSET_SPACE, TILT_SPACE, PoseSpace
from palpate.learn import Coverage, DepthErrors, Metrics, TiltErrors, compare_with_bound, pool_bounds
from palpate.study.grid import Cell, Row, SpecificationGrid
from palpate.study.result import DesignResult, PressSummary

Part = DepthErrors | TiltErrors
Place = tuple[float, ...]
"""A depth (mm), or the ends of an interval of tilt (degrees)."""


def evaluate_grid(designs: Sequence[DesignResult]) -> SpecificationGrid:
    """Tabulate the figures of all designs.

    Parameters
    ----------
    designs
        Records of a study.

    Returns
    -------
    SpecificationGrid
        A row for every design; that of a failed design has empty figures, and `failure` has the reason.
    """
    numbered = list(enumerate(designs))
    return SpecificationGrid(
        designs=_table(_row(design) for design in designs),
        by_depth=_table({"design": number, **row} for number, design in numbered for row in _by_depth(design)),
        by_tilt=_table({"design": number, **row} for number, design in numbered for row in _by_tilt(design)),
        presses=_table({"design": number, **_press(one)} for number, design in numbered for one in design.presses),
    )


def _table(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Return rows that all have every column; cells without a figure are empty."""
    found = list(rows)
    columns = dict.fromkeys(name for row in found for name in row)
    return tuple({name: row.get(name) for name in columns} for row in found)


def _by_depth(design: DesignResult) -> list[Row]:
    """Errors, bounds and their ratio, by ascending depth."""
    errors = _by_place(design, lambda metrics: {(round(part.depth_mm, 6),): part for part in metrics.by_depth})
    limits = {round(limit.depth_mm, 6): limit for limit in design.bounds}
    rows: list[Row] = []
    unit = _unit(design)
    for depth in sorted({*limits, *(place[0] for place in errors)}):
        limit, found = limits.get(depth), errors.get((depth,), _errors_of(None, None, unit))
        rmse, bound = found[f"rmse_jitter_{unit}"], limit.least_squares_deg if limit else None
        row = {
            "depth_mm": depth,
            **found,
            f"bound_{unit}": bound,
            f"bound_pitman_{unit}": limit.pitman_deg if limit else None,
            f"bound_floor_{unit}": limit.floor_deg if limit else None,
            "rmse_over_bound": rmse / bound if isinstance(rmse, float) and bound else None,
        }
        rows.append(row)
    return rows


def _by_tilt(design: DesignResult) -> list[Row]:
    """Errors by ascending interval of true tilt."""
    errors = _by_place(design, lambda metrics: {(part.from_deg, part.to_deg): part for part in metrics.by_tilt})
    return [{"tilt_from_deg": ends[0], "tilt_to_deg": ends[1], **errors[ends]} for ends in sorted(errors)]


def _by_place(design: DesignResult, cut: Callable[[Metrics], Mapping[Place, Part]]) -> dict[Place, dict[str, Cell]]:
    """Clean and jittered errors of a design at the places that `cut` returns."""
    clean, jittered = (cut(metrics) if metrics else {} for metrics in (design.clean, design.jittered))
    unit = _unit(design)
    return {place: _errors_of(clean.get(place), jittered.get(place), unit) for place in {**clean, **jittered}}


def _errors_of(clean: Part | None, jittered: Part | None, unit: str) -> dict[str, Cell]:
    counted = clean or jittered
    images = {"validation_samples": counted.images if counted else None}
    return {**_errors(clean, "", unit), **_errors(jittered, "_jitter", unit), **images}


def _press(press: PressSummary) -> Row:
    cells = {name: _finite(cell) if isinstance(cell, float) else cell for name, cell in asdict(press).items()}
    position = {str(cells.pop("position_column")): cells.pop("position")}
    if press.azimuth_deg is None:
        del cells["azimuth_deg"]
    return position | cells


def _row(design: DesignResult) -> dict[str, Cell]:
    return {
        "height_mm": design.design.skin.height,
        "base_radius_mm": design.design.skin.base_radius,
        "thickness_mm": design.design.skin.thickness,
        "shape": str(design.design.skin.shape),
        "markers": len(design.design.layout),
        **_built(design.built),
        **_errors(design.clean, "", _unit(design)),
        **_errors(design.jittered, "_jitter", _unit(design)),
        **_spread(design),
        **_limits(design),
        **_coverage(design.coverage, _unit(design)),
        "travel_mm": _finite(design.travel_mm),
        "peak_stress_mpa": _finite(design.peak_stress_mpa),
        **_presses(design.presses),
        "force_n": _finite(design.force_n),
        "bistable_from_mm": _finite(design.bistable_from_mm),
        **_evidence(design),
        **_details(design.clean, ""),
        **_details(design.jittered, "_jitter"),
        "failure": design.failure,
        "seed": design.seed,
        **{f"{stage}_seed": design.spec.get(stage, {}).get("seed") for stage in ("dataset", "learning")},
        "versions": json.dumps(dict(design.versions), sort_keys=True),
        "spec": json.dumps(design.spec, sort_keys=True),
        **{f"{kind}_key": " ".join(keys) for kind, keys in design.artefacts.items()},
    }


def _errors(metrics: Metrics | Part | None, suffix: str, unit: str) -> dict[str, Cell]:
    return {
        f"rmse{suffix}_{unit}": metrics.pooled.rmse if metrics else None,
        f"max_error{suffix}_{unit}": metrics.pooled.max if metrics else None,
    }


def _unit(design: DesignResult) -> str:
    """Unit of the estimated position: degrees of a tilt, or mm of an offset."""
    return "mm" if any(press.position_column == "offset_mm" for press in design.presses) else "deg"


def _built(figures: Sequence[PredictedAccuracy]) -> dict[str, Cell]:
    """Predicted accuracy of built units, without and with calibration presses."""
    if not figures:
        return {}
    first, known = figures
    return {
        "built_rmse_deg": first.rmse_deg,
        "built_p95_deg": first.p95_deg,
        "calibrated_rmse_deg": known.rmse_deg,
        "calibrated_p95_deg": known.p95_deg,
        "calibrated_depth_rmse_mm": known.depth_rmse,
        "calibration_presses": known.calibration_presses,
    }


def _spread(design: DesignResult) -> dict[str, Cell]:
    """Standard deviation of the clean RMSE over at least two repeats."""
    repeats = design.repeat_rmse_deg
    return {
        f"rmse_spread_{_unit(design)}": statistics.stdev(repeats) if len(repeats) > 1 else None,
        "repeats": len(repeats) or None,
    }


def _limits(design: DesignResult) -> dict[str, Cell]:
    """Bounds on the jittered RMSE and its ratio to them, over all depths."""
    judged = compare_with_bound(design.jittered, design.bounds) if design.jittered else None
    pooled = judged[0] if judged else pool_bounds(design.bounds)
    unit = _unit(design)
    return {
        f"bound_{unit}": pooled.least_squares_deg if pooled else None,
        f"bound_pitman_{unit}": pooled.pitman_deg if pooled else None,
        "rmse_over_bound": judged[1] if judged else None,
    }


def _coverage(coverage: Coverage | None, unit: str) -> dict[str, Cell]:
    """Coverage of the intervals on presses that did not calibrate them."""
    position = "deg" if unit == "deg" else f"offset_{unit}"
    return {
        "interval_level": coverage.level if coverage else None,
        "interval_coverage": coverage.angle if coverage else None,
        "interval_coverage_depth": coverage.depth if coverage else None,
        f"interval_half_width_{position}": coverage.half_width_deg if coverage else None,
        "interval_half_width_mm": coverage.half_width_mm if coverage else None,
        "interval_presses": coverage.presses if coverage else None,
        "flagged_ood": coverage.flagged_ood if coverage else None,
    }


def _details(metrics: Metrics | None, suffix: str) -> dict[str, Cell]:
    """Every summary figure per axis."""
    if metrics is None:
        return {}
    found: dict[str, Cell] = {}
    space = next(each for each in (TILT_SPACE, PoseSpace.for_lines(), OFFSET_SPACE) if each.fits(metrics.by_axis))
    for axis, _, unit in space.errors:
        summary = metrics.by_axis[axis]
        for figure in ("rmse", "mae", "max", "sd", "bias"):
            if axis == space.polar and figure in ("rmse", "max"):
                continue  # these two are the grid's main columns
            found[f"{figure}_{axis}{suffix}_{unit}"] = getattr(summary, figure)
    return found


def _presses(presses: Sequence[PressSummary]) -> dict[str, Cell]:
    """Deformation of the skin: in the press of minimum tilt, and maxima over all presses."""
    straight = min(presses, key=lambda press: press.position) if presses else None
    return {
        "peak_stress_straight_mpa": straight.peak_stress_mpa if straight else None,
        "displacement_max_straight_mm": straight.displacement_max_mm if straight else None,
        "displacement_mean_straight_mm": straight.displacement_mean_mm if straight else None,
        "displacement_max_mm": max((press.displacement_max_mm for press in presses), default=None),
        "apex_gap_mm": max((press.apex_gap_mm for press in presses), default=None),
    }


def _evidence(design: DesignResult) -> dict[str, Cell]:
    """Numbers of presses, images and dropped poses of a design, and branches of its presses."""
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
