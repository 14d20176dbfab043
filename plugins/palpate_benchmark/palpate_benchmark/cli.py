"""`palpate benchmark`: make the data set, score predictions, and run the baselines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from palpate.cli.border import keep_results
from palpate.cli.output import Output, check_file, check_folder
from palpate.cli.progress import show_progress
from palpate.cli.run import WorkerFlags
from palpate.core.report import Column, Report, write_csv

app = App(name="benchmark", help="Open data set of images of built units, scores of predictions, and baselines.")

_SPEC = "YAML file with the contents of the data set, or a preset: full, tiny."
_HIDDEN = "Seed of the test units and of the image numbers; no file of the set contains it."
_SET = "Folder of the set: OUT/set of palpate benchmark make."
_PREDICTIONS = (
    "Table (.csv) with the columns image, rx_deg, ry_deg, depth_mm, and optionally force_n and half-widths of "
    "intervals."
)
_COUNTS = (
    Column("split"),
    Column("presses"),
    Column("images"),
    Column("pictures", "rendered images"),
)
_ONLY = "Baselines to run: ridge, paper, network, twin, picture; by default all."
_BASELINES = "YAML file with the settings of the baselines, or tiny for a tiny set; by default as documented."


@app.command
def make(
    spec: Annotated[str, Parameter(help=_SPEC)] = "full",
    *,
    out: Annotated[
        Path, Parameter(name=("--out", "-o"), help="Result folder; the same command resumes an interrupted run.")
    ],
    seed: Annotated[
        int | None, Parameter(help="Seed of units, poses, noise and numbers; by default that of the spec.")
    ] = None,
    hidden_seed: Annotated[int | None, Parameter(help=_HIDDEN)] = None,
    worker_flags: WorkerFlags = WorkerFlags(),
    output: Output = Output(),
) -> None:
    """Write the data set into OUT/set; the same seed gives the same bytes."""
    from palpate_benchmark import BenchmarkSpec, make_benchmark, read_benchmark_spec

    check_folder(out)
    worker_flags.check()
    chosen = read_benchmark_spec(spec)
    given = {name: value for name, value in (("seed", seed), ("hidden_seed", hidden_seed)) if value is not None}
    chosen = BenchmarkSpec.model_validate({**chosen.model_dump(), **given})
    with show_progress() as progress:
        made = make_benchmark(chosen, keep_results(out), worker_flags.workers, progress)
    counts = made.counts
    told = {"images": counts.images, "pictures": counts.pictures, "presses": counts.presses}
    rows = [(split, counts.presses[split], counts.images[split], counts.pictures[split]) for split in counts.images]
    output.show(
        {"set": str(made.folder), "bytes": made.bytes, "sha256": made.sha256, **told},
        Report.of("The set", _COUNTS, rows),
        f"{made.folder}: {made.bytes / 1e6:.1f} MB, SHA256SUMS has the checksum {made.sha256}.",
    )


@app.command
def score(
    predictions: Annotated[Path, Parameter(help=_PREDICTIONS)],
    *,
    folder: Annotated[Path, Parameter(name="--set", help=_SET)],
    track: Annotated[
        Literal["markers", "pictures"],
        Parameter(help="Scored images: all of the test (markers), or the rendered ones (pictures)."),
    ] = "markers",
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help="File for all scores (.csv).")] = None,
    output: Output = Output(),
) -> None:
    """Score a table of predictions by the hidden labels."""
    from palpate_benchmark import SCORE_COLUMNS, read_set, score_file, score_report, score_rows

    check_file(out, ".csv")
    found = score_file(read_set(folder), predictions, track)
    if out is not None:
        write_csv(out, score_rows(found), SCORE_COLUMNS)
    output.show(
        found.as_dict(),
        score_report(f"{predictions.name}, {track}: degrees, mm and N", found),
        f"The 95th percentile of the errors of rx and ry of the worst unit is {found.worst_unit_p95_deg:.3f}°.",
    )


@app.command
def baselines(
    *,
    folder: Annotated[Path, Parameter(name="--set", help=_SET)],
    out: Annotated[
        Path, Parameter(name=("--out", "-o"), help="Result folder; the same command resumes an interrupted run.")
    ],
    spec: Annotated[str | None, Parameter(help=_BASELINES)] = None,
    only: Annotated[tuple[str, ...], Parameter(help=_ONLY, negative="", consume_multiple=True)] = (),
    worker_flags: WorkerFlags = WorkerFlags(),
    output: Output = Output(),
) -> None:
    """Run five baselines, score each, and compare them in a table."""
    from palpate_benchmark import BASELINES, compare_report, read_baseline_spec, read_set, run_baselines

    check_folder(out)
    worker_flags.check()
    chosen = read_baseline_spec(spec)
    with show_progress() as progress:
        scores = run_baselines(read_set(folder), chosen, keep_results(out), only, worker_flags.workers, progress)
    table = compare_report({BASELINES[name]: own for name, own in scores.items()})
    output.show({name: [each.as_dict() for each in own] for name, own in scores.items()}, "Baselines", table)
