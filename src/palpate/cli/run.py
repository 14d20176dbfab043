"""`palpate run`: a study from its file to its specification grid."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from palpate.cli.border import keep_results
from palpate.cli.compiling import announce_compilation
from palpate.cli.output import RESULTS, OutFlag, Output
from palpate.cli.progress import show_progress
from palpate.core import PalpateError

if TYPE_CHECKING:
    from palpate.study import Row, StudyResult

_PREDICTION_ERROR = 0.02
"""Relative error of a predicted RMSE compared with 56 presses (docs/design_notes/study.md)."""
_SIZES = {
    "height": "height_mm",
    "base-radius": "base_radius_mm",
    "thickness": "thickness_mm",
    "markers": "markers",
}
"""Flags of a dome's design, and their columns."""


@Parameter(name="*")
@dataclass(frozen=True)
class WorkerFlags:
    """Number of worker processes on this machine."""

    workers: Annotated[
        int | None, Parameter(help="Number of worker processes; by default one per core, if memory suffices.")
    ] = None

    def check(self) -> None:
        """Raise a `PalpateError` if a flag is out of bounds."""
        from palpate.core.run import MOST_WORKERS
        from palpate.study import available_cores

        if self.workers is not None and not 1 <= self.workers <= MOST_WORKERS:
            raise PalpateError(
                f"--workers is {self.workers}.",
                f"Give 1 to {MOST_WORKERS}; this machine has {available_cores()} cores.",
                code="option-out-of-bounds",
            )


@Parameter(name="*")
@dataclass(frozen=True)
class ClusterFlags(WorkerFlags):
    """Workers: processes of this machine, or a cluster."""

    cluster: Annotated[
        str | None,
        Parameter(
            help="Dask cluster instead of worker processes: local:N, or the scheduler's address tcp://HOST:PORT."
        ),
    ] = None

    def check(self) -> None:
        """Raise a `PalpateError` if a flag is out of bounds or the flags exclude each other."""
        from palpate.study import check_cluster_address

        super().check()
        if self.cluster is not None:
            check_cluster_address(self.cluster)
            if self.workers is not None:
                raise PalpateError(
                    "--workers and --cluster exclude each other.", "Give one of them.", code="options-exclusive"
                )


@Parameter(name="*")
@dataclass(frozen=True)
class TaskFlags(ClusterFlags):
    """Workers of a study, and time limit of a task."""

    timeout: Annotated[
        float | None,
        Parameter(help="Time limit of a task, s (>= 1); by default one hour plus 200 times the expected time."),
    ] = None

    def check(self) -> None:
        """Raise a `PalpateError` if a flag is out of bounds or the flags exclude each other."""
        super().check()
        if self.timeout is not None and not 1.0 <= self.timeout < math.inf:
            raise PalpateError(f"--timeout is {self.timeout:g} s.", "Give 1 s or more.", code="option-out-of-bounds")


def run(
    study: Annotated[str, Parameter(help="YAML file of the study, or a preset: first, paper, best.")],
    *,
    out: OutFlag = None,
    worker_flags: TaskFlags = TaskFlags(),
    device: Annotated[
        Literal["cpu", "cuda", "auto"] | None, Parameter(help="Device of the training; by default that of the study.")
    ] = None,
    output: Output = Output(),
) -> int:
    """Run a study: finite-element presses, data, training and accuracy of every design.

    Results in the result folder are reused: the same command resumes an interrupted study.
    """
    from palpate.study import evaluate_grid, grid_report, ranking_column, read_study, run_study, sort_rows, write_grid

    chosen = read_study(study)
    if device is not None:
        chosen = chosen.model_copy(update={"learning": chosen.learning.model_copy(update={"device": device})})
    worker_flags.check()
    folder = keep_results(out or RESULTS / chosen.name)
    announce_compilation()
    with show_progress(quiet=output.json) as progress:
        result = run_study(chosen, folder, worker_flags.workers, progress, worker_flags.timeout, worker_flags.cluster)
    grid = evaluate_grid(result.designs)
    replaced = _describe_replaced(folder, grid.designs)
    write_grid(folder, grid)
    rows = sort_rows(grid.designs, ranking_column(grid.columns))
    output.show(
        {"out": str(folder), **_tally(result), "designs": grid.designs},
        grid_report(rows, title=chosen.name, file=str(folder / "grid.csv")),
        f"{_sentence(result)} Results: {folder}",
        *replaced,
        *_describe_best(rows, ranking_column(grid.columns), folder),
    )
    for failure in result.failures:
        print(f"{failure.task}: {failure.reason}", file=sys.stderr)
    for design in result.designs:
        if design.clean and design.failure:
            name = f"{design.design.skin.name}, {len(design.design.layout)} markers"
            print(f"{name}: {design.failure}", file=sys.stderr)
    return 1 if result.failures else 0


def _describe_replaced(folder: Path, designs: Sequence[Row]) -> tuple[str, ...]:
    """Return a sentence on the earlier tables of a folder that other results replace."""
    from palpate.study import is_grid, read_grid

    try:
        before = read_grid(folder).designs if is_grid(folder) else ()
    except PalpateError:  # a damaged table
        return ()
    lost = sum(row not in designs for row in before)
    return (f"Replaced the earlier tables in {folder}: {lost} of {len(before)} rows differ.",) if lost else ()


def _tally(result: StudyResult) -> dict[str, Any]:
    return {
        "study": result.name,
        "computed": dict(result.computed),
        "reused": dict(result.reused),
        "wall_s": result.wall_s,
        "failures": [{"task": failure.task, "reason": failure.reason} for failure in result.failures],
    }


def _sentence(result: StudyResult) -> str:
    made, found = sum(result.computed.values()), sum(result.reused.values())
    minutes, seconds = divmod(round(result.wall_s), 60)
    took = f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
    return f"Computed {made} results, reused {found}; {took}."


def _describe_best(rows: Sequence[Row], rank: str, folder: Path) -> Iterator[str]:
    """Sentences on the best design, its uncertainty and the next step; `rows` are sorted by `rank`."""
    from palpate.study import design_label, design_spec, grid_column

    values = [float(value) for row in rows if (value := row.get(rank)) is not None]  # those without one are last
    if not values:
        return
    best, column, built = rows[0], grid_column(rank), rank == "built_rmse_deg"
    after = f", {best['calibrated_rmse_deg']:.2g}° after {best['calibration_presses']} presses" if built else ""
    unit = "°" if column.measure == "°" else f" {column.measure}"
    yield f"Best design: {design_label(best)}: {column.title} {values[0]:.2g}{unit}{after}."
    spread = float(best.get("rmse_spread_deg") or 0.0) / float(best.get("rmse_deg") or 1.0)
    known = _PREDICTION_ERROR if built else spread
    count = sum(value <= (1 + known) * values[0] for value in values)
    equal = [design_label(row) for row in rows[1:count]]
    others = f"; equal within it: {'; '.join(equal)}" if equal else "; no other design is within it"
    yield (
        f"Uncertainty of this figure: {100 * known:.0f} %{others}."
        if known
        else "Its uncertainty is unknown, since the spread over repeated trainings is missing."
    )
    if "skin" in design_spec(best):
        yield f"Next: `palpate view {folder}` shows its presses."
        return
    sizes = " ".join(f"--{name} {best[column]:g}" for name, column in _SIZES.items())
    yield f"Next: `palpate design make {sizes} --out NAME` writes molds; `palpate view {folder}` shows presses."
