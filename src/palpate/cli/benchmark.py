"""`palpate benchmark`: make the open set, judge predictions of it, and run the baselines."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from palpate.cli.flag import JsonFlag
from palpate.cli.output import check_file, check_folder, print_json, print_table
from palpate.cli.progress import Lines
from palpate.cli.run import WorkerFlags
from palpate.core import atomic_write

app = App(name="benchmark", help="An open set of images of built units, the judge of predictions, and baselines.")

_SPEC = "YAML file of what the set holds, or a preset: full, tiny."
_HIDDEN = "Seed of the test's units and of the numbering, which no file of the set tells."
_SET = "Folder of the set: OUT/set of palpate benchmark make."
_PREDICTIONS = (
    "Table (.csv) with the columns image, rx_deg, ry_deg, depth_mm, and if wished force_n and half-widths of "
    "intervals."
)
_MORE = ("in interval", "half-width")
"""Figures that only the file and the JSON have."""
_ONLY = "Baselines that are run: ridge, paper, network, twin, picture; without it, all."
_BASELINES = "YAML file of how baselines are made; without it, as documented, or for a tiny set, in seconds: tiny."


@app.command
def make(
    spec: Annotated[str, Parameter(help=_SPEC)] = "full",
    *,
    out: Annotated[
        Path, Parameter(name=("--out", "-o"), help="Result folder; the same command goes on where it was stopped.")
    ],
    seed: Annotated[int | None, Parameter(help="Seed of everything; without it, as the spec says.")] = None,
    hidden_seed: Annotated[int | None, Parameter(help=_HIDDEN)] = None,
    worker_flags: WorkerFlags = WorkerFlags(),
    json: JsonFlag = False,
) -> None:
    """Write the open set into OUT/set, the same bytes from the same seed."""
    from palpate.benchmark import BenchmarkSpec, make_benchmark, read_benchmark_spec

    check_folder(out)
    worker_flags.check()
    chosen = read_benchmark_spec(spec)
    given = {name: value for name, value in (("seed", seed), ("hidden_seed", hidden_seed)) if value is not None}
    chosen = BenchmarkSpec.model_validate({**chosen.model_dump(), **given})
    made = make_benchmark(chosen, out, worker_flags.workers, Lines())
    counts = made.counts
    if json:
        told = {"images": counts.images, "pictures": counts.pictures, "presses": counts.presses}
        print_json({"set": str(made.folder), "bytes": made.bytes, "sha256": made.sha256, **told})
        return
    rows = [
        [split, str(counts.presses[split]), str(counts.images[split]), str(counts.pictures[split])]
        for split in counts.images
    ]
    print_table("The set", ["split", "presses", "images", "pictures"], rows)
    print(f"{made.folder}: {made.bytes / 1e6:.1f} MB, SHA256SUMS has the checksum {made.sha256}.")


@app.command
def score(
    predictions: Annotated[Path, Parameter(help=_PREDICTIONS)],
    *,
    folder: Annotated[Path, Parameter(name="--set", help=_SET)],
    track: Annotated[
        Literal["markers", "pictures"], Parameter(help="All images of the test, or those that have a picture.")
    ] = "markers",
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help="File for every figure (.csv).")] = None,
    json: JsonFlag = False,
) -> None:
    """Judge a table of predictions by the hidden labels."""
    import csv

    from palpate.benchmark import SCORE_COLUMNS, read_set, score_file, score_rows

    check_file(out, ".csv")
    found = score_file(read_set(folder), predictions, track)
    rows = score_rows(found)
    if out is not None:
        with atomic_write(out) as draft, draft.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([SCORE_COLUMNS, *rows])
    if json:
        print_json(found.as_dict())
        return
    shown = [k for k, name in enumerate(SCORE_COLUMNS) if name.split(" ", 1)[-1] not in _MORE]
    table = [[row[k] for k in shown] for row in rows]
    print_table(f"{predictions.name}, {track}: degrees, mm and N", [SCORE_COLUMNS[k] for k in shown], table)
    print(f"Of the worst unit 19 of 20 values of rx and ry are within {found.worst_unit_p95_deg:.3f}°.")


@app.command
def baselines(
    *,
    folder: Annotated[Path, Parameter(name="--set", help=_SET)],
    out: Annotated[
        Path, Parameter(name=("--out", "-o"), help="Result folder; the same command goes on where it was stopped.")
    ],
    spec: Annotated[str | None, Parameter(help=_BASELINES)] = None,
    only: Annotated[tuple[str, ...], Parameter(help=_ONLY, negative="", consume_multiple=True)] = (),
    worker_flags: WorkerFlags = WorkerFlags(),
    json: JsonFlag = False,
) -> None:
    """Run five baselines, judge each, and hold them against each other in a table."""
    from palpate.benchmark import read_baseline_spec, read_set, run_baselines

    check_folder(out)
    worker_flags.check()
    chosen = read_baseline_spec(spec)
    scores = run_baselines(read_set(folder), chosen, out, only, worker_flags.workers, _print_line)
    if json:
        print_json({name: [each.as_dict() for each in own] for name, own in scores.items()})
        return
    print((out / "baselines.md").read_text(encoding="utf-8").strip())


def _print_line(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
