"""`palpate simulation bench`: simulated units that deviate from a design, and their error budget."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from pydantic import ValidationError

from palpate.calibration import ToleranceSpec
from palpate.camera import RenderSpec
from palpate.cli.border import keep_results
from palpate.cli.compiling import announce_compilation
from palpate.cli.flag import flags_of
from palpate.cli.output import RESULTS, Output, check_folder
from palpate.cli.progress import show_progress
from palpate.cli.unit import DesignFlags, ModelFlags
from palpate.core import ArtefactStore, PalpateError
from palpate.core.report import Column, Report, plain_page, write_csv
from palpate.core.run import Progress
from palpate.simulation import VirtualBenchSpec

if TYPE_CHECKING:
    from palpate.simulation import VirtualBench
    from palpate.surrogate import Twin

_OUT = "Folder for tables and presses. The same command resumes an interrupted run."
_TOLERANCE = "Tolerances as NAME=VALUE: " + ", ".join(ToleranceSpec.model_fields) + "."
_BUDGET = (
    "Error of each deviation alone, instead of sampled units; computed without simulation if the model is a twin."
)
_SIMULATED = (
    Column("label", "imperfection", prose=True),
    Column("tolerance"),
    Column("angle_deg", "angle RMS", form=".3f", meaning="RMS change of rx and ry"),
    Column("angle_max_deg", "angle maximum", form=".3f", meaning="maximum change of rx and ry"),
    Column("depth", "depth RMS", "mm", form=".3f", meaning="RMS change of the depth"),
    Column("units", deciding=False, meaning="simulated units"),
)
_CLEAN = "Render images without uneven light, blur, noise and dirt."


@Parameter(name="*")
@dataclass(frozen=True)
class BenchFlags:
    """Design, estimator, test bench, tolerances and images of the units."""

    design: DesignFlags = DesignFlags()
    reads: ModelFlags = ModelFlags()
    spec: Annotated[VirtualBenchSpec, flags_of(VirtualBenchSpec, without="tolerance render", group="Test bench")] = (
        VirtualBenchSpec()
    )
    tolerance: Annotated[tuple[str, ...], Parameter(help=_TOLERANCE, negative="", consume_multiple=True)] = ()
    clean: Annotated[bool, Parameter(negative="", help=_CLEAN)] = False

    def chosen(self) -> VirtualBenchSpec:
        """The spec of these flags."""
        tolerance = read_tolerance(self.tolerance)
        render = RenderSpec() if self.clean else self.spec.render
        return self.spec.model_copy(update={"tolerance": tolerance, "render": render})


def bench(
    *,
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    flags: BenchFlags = BenchFlags(),
    budget: Annotated[bool, Parameter(negative="", help=_BUDGET)] = False,
    output: Output = Output(),
) -> None:
    """Simulate the paper's experiment on built units that deviate from the design within tolerances."""
    from palpate.simulation import VirtualBench
    from palpate.surrogate import Twin

    check_folder(out)
    chosen, model = flags.chosen(), _model(flags)
    store = ArtefactStore(keep_results(out) / "store")
    played = VirtualBench(chosen, flags.design.design(flags.reads.material), model, store)
    played.check()
    announce_compilation()
    if budget and isinstance(played.opened_model, Twin):
        _predicted(played, played.opened_model, out, output)
    else:
        (_budget if budget else _units)(played, out, output)


def _model(flags: BenchFlags) -> Path:
    """Return the model as `palpate sensor live` finds it; make a missing twin first."""
    from palpate.study import export_twins, run_twins, single_design_study
    from palpate.surrogate import twin_path

    skin = flags.design.skin_spec()
    try:
        return flags.reads.find(flags.design)
    except PalpateError as error:
        if flags.reads.model is not None:
            raise
        why, remedy = "a twin has one press a tilt for all azimuths", "Give a trained network by --model."
        skin.build().require_revolution(why, remedy, code="twin-needs-revolution")
        _print_result(f"{error.problem} It is made and stored first: about 3 minutes on one core.")
    study = single_design_study(skin, flags.design.markers, flags.reads.material)
    folder = keep_results(RESULTS / study.name)
    with show_progress() as progress:
        made = run_twins(study, folder, progress=progress)[0]
    if made.twin is None:
        raise PalpateError(
            f"The twin of {skin.build().name} could not be made: {made.problem}",
            "Give a trained network by --model.",
            code="twin-not-made",
        )
    export_twins(folder, [(made.design.skin_spec, made.twin)])
    return twin_path(folder, skin.build())


def _units(trials: VirtualBench, out: Path, output: Output) -> None:
    from palpate.simulation import bench_summary, describe_bench, run_bench, write_bench

    results, progress, count = [], Progress(), trials.spec.units + 1
    progress.plan(count)
    progress.begin("unit")
    for result in run_bench(trials):
        results.append(result)
        progress.finish("unit")
        remaining = ", ".join(filter(None, (f"{len(results)}/{count}", progress.remaining_text)))
        progress.begin("unit")
        angles = " ".join(f"{s.component} {s.errors.rmse:.3f}/{s.errors.max:.2f}°" for s in result.scores[:2])
        name = f"unit {result.number}" if result.number else "nominal unit"
        _print_result(f"[{remaining}] {name}: {result.trial.failure or angles}")
        write_bench(out, trials, results)
    page = bench_summary(trials, results)
    output.show(describe_bench(trials, results), *plain_page(page), f"Tables: {out}")


def _predicted(trials: VirtualBench, twin: Twin, out: Path, output: Output) -> None:
    """Write and print the error budget of units with a twin as estimator, computed without simulation."""
    from palpate.calibration import AccuracySpec, UncertaintyBudget

    spec, design = (
        AccuracySpec(min_depth=trials.spec.min_depth, max_tilt_deg=trials.spec.max_tilt_deg, seed=trials.spec.seed),
        trials.design,
    )
    budget = UncertaintyBudget.of_design(twin, design.layout, design.camera, trials.spec.tolerance, spec)
    found = budget.report()
    out.mkdir(parents=True, exist_ok=True)
    write_csv(out / "budget.csv", [list(row.values()) for row in found.rows], [each.title for each in found.columns])
    table = replace(found, title="error budget, predicted", notes=(f"Table: {out / 'budget.csv'}",))
    output.show({"lines": [line.as_dict() for line in budget.components]}, table)


def _budget(trials: VirtualBench, out: Path, output: Output) -> None:
    from palpate.simulation import describe_budget, run_budget, write_budget

    lines = []
    for line in run_budget(trials):
        lines.append(line)
        _print_result(f"{line.label}: {line.angle_deg:.3f}°")
        write_budget(out, trials, lines)
    described = describe_budget(trials, lines)
    total = f"Root sum of squares of all: {described['total_angle_deg']:.3f}°. Tables and chart: {out}"
    output.show(described, Report("error budget", _SIMULATED, described["lines"], (total,)))


def read_tolerance(texts: tuple[str, ...]) -> ToleranceSpec:
    """Read tolerances from texts NAME=VALUE."""
    try:
        return ToleranceSpec.model_validate(dict(_read_pair(text) for text in texts))
    except ValidationError as error:
        first = error.errors()[0]
        raise PalpateError(
            f"--tolerance: {ToleranceSpec.describe_value(first, str(first['loc'][0]))}.",
            "See `palpate.calibration.ToleranceSpec` for units and bounds.",
            code="tolerance-out-of-bounds",
        ) from None


def _read_pair(text: str) -> tuple[str, str]:
    name, sign, value = text.partition("=")
    if not sign or name not in ToleranceSpec.model_fields:
        raise PalpateError(
            f"Unknown tolerance '{text}'.",
            f"Write NAME=VALUE with one of {', '.join(ToleranceSpec.model_fields)}.",
            code="tolerance-unknown",
        )
    return name, value


def _print_result(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
