"""Result of a test bench: nominal unit, sampled units, and comparison with the paper's sensor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np

from palpate.calibration import Deviation, ToleranceSpec, sample_deviation
from palpate.core import parameters
from palpate.core.report import Report
from palpate.sensor import PAPER_TABLE_3, Score, provenance_line, score_readings, write_report
from palpate.simulation.run_trial import VirtualBench, run_unit_trial
from palpate.simulation.spec import VirtualBenchSpec
from palpate.simulation.trial import MEASURANDS, POSE, ParameterEstimate, UnitTrial, collect_estimates, covered_share

WANTED_RMSE_DEG, WANTED_MAX_DEG = 0.58, 1.64
"""RMSE and maximum error of roll and pitch of the paper's sensor."""
COLUMNS = ("unit", "component", "images", "presses", "RMSE", "MAE", "max", "SD", "bias", "without pose", "flagged")


@dataclass(frozen=True, eq=False)
class UnitResult:
    """Errors of one unit.

    Attributes
    ----------
    number
        0 for the nominal unit.
    trial
        Its readings.
    scores
        Roll, pitch and depth; empty if the simulation failed or gave no pose.
    """

    number: int
    trial: UnitTrial
    scores: tuple[Score, ...]

    @property
    def without_pose(self) -> int:
        """Number of images without a pose."""
        return int((~np.isfinite(self.trial.estimates).all(axis=1)).sum())

    @property
    def meets_paper(self) -> bool:
        """Whether every image gave a pose, and roll and pitch are at least as good as the paper's."""
        if not self.scores or self.without_pose:
            return False
        angles = [score.errors for score in self.scores[:2]]
        return all(error.rmse <= WANTED_RMSE_DEG and error.max <= WANTED_MAX_DEG for error in angles)


def run_bench(bench: VirtualBench) -> Iterator[UnitResult]:
    """Simulate the nominal and the sampled units; results in the store are reused.

    Raises
    ------
    PalpateError
        If a press cannot be solved, or the model is not of this design.
    """
    bench.check()
    for number in range(bench.spec.units + 1):
        deviation = sample_deviation(bench.spec.tolerance, bench.spec.seed, number) if number else Deviation()
        yield score_unit(number, run_unit_trial(bench, deviation))


def score_unit(number: int, trial: UnitTrial) -> UnitResult:
    """Score the images of a unit."""
    if not np.isfinite(trial.estimates).all(axis=1).any():
        return UnitResult(number, trial, ())
    return UnitResult(number, trial, score_readings(trial.truth, trial.corrected(), trial.press))


def pool_units(results: Sequence[UnitResult], *, trusted: bool = False) -> tuple[Score, ...]:
    """Score the images of all sampled units together, each unit's presses separately; empty without any.

    With `trusted`, only images without a flag count.
    """
    units = [result for result in results if result.number and result.scores]
    if not units:
        return ()
    truth = np.concatenate([result.trial.truth for result in units])
    estimates = np.concatenate([result.trial.corrected() for result in units])
    press = np.concatenate([1000 * result.number + result.trial.press for result in units])
    kept = ~np.concatenate([result.trial.flagged for result in units]) | (not trusted)
    return score_readings(truth[kept], estimates[kept], press[kept]) if kept.any() else ()


def describe_bench(bench: VirtualBench, results: Sequence[UnitResult]) -> dict[str, Any]:
    """Return the bench as JSON data: settings, versions, and every unit."""
    sampled = [result for result in results if result.number]
    return {
        **bench.facts(),
        "material": bench.design.material.key_data(),
        "camera": bench.design.camera_spec.model_dump(mode="json"),
        "units": [_describe_unit(result) for result in results],
        "pooled": [score.as_dict() for score in pool_units(results)],
        "as_good_as_the_paper": {"units": sum(result.meets_paper for result in sampled), "of": len(sampled)},
    }


def write_bench(folder: Path, bench: VirtualBench, results: Sequence[UnitResult]) -> None:
    """Write ``bench.json``, ``bench.csv`` and ``bench.md`` into a folder.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    table = [COLUMNS, *(row for result in results for row in unit_rows(result))]
    write_report(folder, "bench", describe_bench(bench, results), bench_page(bench, results), table)


def unit_rows(result: UnitResult) -> list[list[str]]:
    """Return rows of a table by `COLUMNS`, one a component."""
    name = unit_name(result.number)
    flagged = int(result.trial.flagged.sum())
    return [
        [name, f"{score.component} {score.unit}", *score_cells(score), str(result.without_pose), str(flagged)]
        for score in result.scores
    ]


def score_cells(score: Score) -> list[str]:
    """Return numbers of images and presses and the five figures as text."""
    errors = score.errors
    figures = (errors.rmse, errors.mae, errors.max, errors.sd, errors.bias)
    return [str(score.images), str(score.presses), *(f"{value:.3f}" for value in figures)]


def unit_name(number: int) -> str:
    """Return ``nominal`` or the number."""
    return str(number) if number else "nominal"


def bench_page(bench: VirtualBench, results: Sequence[UnitResult]) -> list[str | Report]:
    """Return paragraphs and tables of the bench: all units together, then each."""
    return [
        *bench_summary(bench, results),
        "## Every unit",
        Report.of("", COLUMNS, [row for result in results for row in unit_rows(result)]),
        *[f"Unit {result.number}: {result.trial.failure}" for result in results if result.trial.failure],
        "## Tolerances",
        Report.of("", ("deviation", "either way", "unit"), tolerance_rows(bench.spec.tolerance)),
        provenance_line(),
    ]


def bench_summary(bench: VirtualBench, results: Sequence[UnitResult]) -> list[str | Report]:
    """Return paragraphs and tables of all units together."""
    spec, sampled = bench.spec, [result for result in results if result.number]
    return [
        f"# Virtual bench: {bench.name}",
        f"Model {bench.model_sha256[:12]}, no training on the bench. Images {spec.min_depth:g} to {spec.depth:g} "
        f"mm deep, {spec.tilts} tilts up to {spec.max_tilt_deg:g}° in {spec.azimuths} directions each; presses by "
        f"{spec.solver}; seed {spec.seed}. {_beforehand(spec)}",
        Report.of("", ("units", "component", "RMSE", "MAE", "max", "SD"), _summary(results)),
        f"{sum(result.meets_paper for result in sampled)} of {len(sampled)} sampled units have "
        f"RMSE ≤ {WANTED_RMSE_DEG}° and max ≤ {WANTED_MAX_DEG}° in roll and pitch, with a pose from every image.",
        *_parameter_lines(sampled),
        *_single_lines(sampled, known=bool(spec.calibration_presses)),
    ]


def tolerance_rows(tolerance: ToleranceSpec) -> list[list[str]]:
    """Return name, value and unit of every tolerance."""
    return [
        [note.meaning, f"{getattr(tolerance, note.name):g}", "" if note.unit == "1" else note.unit]
        for note in parameters(ToleranceSpec)
    ]


def _summary(results: Sequence[UnitResult]) -> Iterator[list[str]]:
    nominal = next((result.scores for result in results if result.number == 0), ())
    flagged = sum(int(result.trial.flagged.sum()) for result in results if result.number)
    together = [("nominal unit", nominal), ("sampled units together", pool_units(results))]
    if flagged:
        together.append((f"without {flagged} flagged images", pool_units(results, trusted=True)))
    for title, scores in together:
        for score in scores:
            errors = score.errors
            cells = (errors.rmse, errors.mae, errors.max, errors.sd)
            yield [title, f"{score.component} {score.unit}", *(f"{value:.3f}" for value in cells)]
    for name, paper in PAPER_TABLE_3.items():
        unit = "mm" if name == "depth" else "deg"
        cells = (paper.rmse, paper.mae, paper.max, paper.sd)
        yield ["the paper's sensor", f"{name} {unit}", *(f"{value:.2f}" for value in cells)]


def _parameter_lines(sampled: Sequence[UnitResult]) -> list[str | Report]:
    """Unit parameters estimated by calibration presses, compared with the truth."""
    estimates: dict[str, list[ParameterEstimate]] = {}
    for learnt in (each for result in sampled for each in result.trial.parameters):
        estimates.setdefault(learnt.name.split(" of press")[0], []).append(learnt)
    if not estimates:
        return []
    rows = []
    for name, each in estimates.items():
        table = np.array([one[1:] for one in each])
        error, sd = table[:, 1] - table[:, 0], table[:, 2]
        figures = (np.sqrt((error**2).mean()), np.abs(error).max(), sd.mean(), table[:, 3].mean())
        share = covered_share(error, NormalDist().inv_cdf(0.95) * sd)
        rows.append([name, str(len(each)), *(f"{value:.4f}" for value in figures), f"{share:.0%}"])
    head = ("parameter", "of", "rms error", "max", "posterior sd", "prior sd", "in the 90 % interval")
    return [
        "## Unit parameters from calibration presses",
        "In mm, degrees, px, ratios and 1/µ.",
        Report.of("", head, rows),
    ]


def _single_lines(sampled: Sequence[UnitResult], *, known: bool) -> list[str | Report]:
    """Errors of force and friction from single images, and coverage of their intervals."""
    unit_trials = [result.trial for result in sampled if result.scores]
    if not unit_trials or not np.isfinite(collect_estimates(unit_trials, "force_n")[1]).any():
        return []
    rows, small_force = [], "≤ 2 % or 0.01 N"
    for name in MEASURANDS:
        truth, error, half = collect_estimates(unit_trials, name)
        if name in POSE and not known:
            continue  # those of a unit whose seating is not known are of its own frame
        share = np.abs(error) / np.maximum(np.abs(truth), 1e-9)
        small = f"{((share <= 0.02) | (np.abs(error) <= 0.01)).mean():.0%}" if name == "force_n" else ""
        figures = (np.sqrt((error**2).mean()), np.abs(error).max())
        shares = (np.sqrt((share**2).mean()), share.max()) if name == "force_n" else ()
        cells = [*(f"{value:.3f}" for value in figures), *(f"{value:.2%}" for value in shares)]
        rows.append(
            [name, str(len(error)), *cells, *[""] * (4 - len(cells)), small, f"{covered_share(error, half):.0%}"]
        )
    head = ("measurand", "images", "rms", "max", "rms share", "max share", small_force, "in the 90 % interval")
    return ["## Force and friction from single images", Report.of("", head, rows, details=[small_force])]


def _beforehand(spec: VirtualBenchSpec) -> str:
    """Describe the preparation of each unit, and the motion of its robot."""
    procedure = "The depth's zero is " + ("measured by one press in advance." if spec.zero else "not corrected.")
    if spec.calibration_presses:
        procedure = (
            f"Each unit is identified by {spec.calibration_presses} calibration presses and one load-cell reading."
        )
    tolerance = spec.tolerance
    if tolerance.lateral or tolerance.twist_deg:
        procedure += (
            f" Robots drift by up to {tolerance.lateral:g} mm in both directions and {tolerance.twist_deg:g}° in a "
            "press."
        )
    if tolerance.curvature:
        procedure += (
            f" Walls have curvatures of up to {tolerance.curvature:g} /m, calibration presses use a flat one."
        )
    if spec.inverted:
        procedure += f" The last {spec.inverted} units are inverted after their calibration presses."
    if tolerance.friction_max:
        procedure += f" Friction is {tolerance.friction_min:g} to {tolerance.friction_max:g}, even in 1/µ."
    return procedure


def _describe_unit(result: UnitResult) -> dict[str, Any]:
    trial = result.trial
    return {
        "unit": result.number,
        "deviation": trial.deviation.as_dict(),
        "scores": [score.as_dict() for score in result.scores],
        "zero_mm": trial.zero.offset if trial.zero else None,
        "depth_bias_without_zero_mm": float(np.nanmean(trial.estimates[:, 2] - trial.truth[:, 2]))
        if result.scores
        else None,
        "parameters": [each._asdict() for each in trial.parameters],
        "without_pose": result.without_pose,
        "flagged": int(trial.flagged.sum()),
        "latency_ms": np.quantile(trial.latency_ms, [0.5, 0.99]).tolist() if len(trial.latency_ms) else [],
        "as_good_as_the_paper": result.meets_paper,
        "failure": trial.failure,
    }
