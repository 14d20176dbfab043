"""`palpate design convergence`: one press on successively finer meshes, as in the paper's Fig. 9."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from palpate.cli.compiling import announce_compilation
from palpate.cli.output import Output, check_folder
from palpate.cli.press import RefinedFlags
from palpate.cli.unit import MarkerFlags
from palpate.core.report import Column, Report, write_csv
from palpate.design import MarkerSpec
from palpate.fea import CELLS

if TYPE_CHECKING:
    from palpate.fea import MeshResult, Press

_CELLS = "Cells from pole to rim, one number per mesh."
_COLUMNS = (
    Column("cells", meaning="cells from pole to rim"),
    Column("elements"),
    Column("unknowns", deciding=False),
    Column("peak_stress", "peak stress", "MPa", form=".4f", meaning="maximum von Mises stress"),
    Column("stress_error", "stress error", "%", form="+.2f"),
    Column("force", "force", "N", form=".4f"),
    Column("force_error", "force error", "%", form="+.2f"),
    Column("marker_error", "marker error", "%", form=".3f", meaning="RMS distance of the markers over the depth"),
)
_OUT = "Folder for convergence.csv, .png and .svg; without it, only the table is printed."


def convergence(
    *,
    flags: RefinedFlags = RefinedFlags(),
    meshes: Annotated[tuple[int, ...], Parameter(help=_CELLS, consume_multiple=True)] = CELLS,
    markers: MarkerFlags = MarkerSpec(),
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    output: Output = Output(),
) -> None:
    """Solve one press on successively finer meshes; compare maximum stress, force and markers."""
    from palpate.design import place_markers
    from palpate.fea import study_convergence

    points = place_markers(flags.shape.skin_spec().build(), markers).positions
    check_folder(out)
    problem = flags.problem()
    announce_compilation()
    results = study_convergence(*problem, points, meshes, _print_mesh)
    if out is not None:
        _write_results(out, results)
    output.show([asdict(result) for result in results], _report(results, out))


def _print_mesh(cells: int, press: Press) -> None:
    print(f"{cells} cells: {press.ended}, {press.cpu_s:.1f} CPU-seconds", file=sys.stderr)


def _write_results(out: Path, results: Sequence[MeshResult]) -> None:
    from palpate.fea import MeshResult, plot_convergence

    out.mkdir(parents=True, exist_ok=True)
    rows = [[f"{value:.6g}" for value in asdict(result).values()] for result in results]
    write_csv(out / "convergence.csv", rows, [field.name for field in fields(MeshResult)])
    figure = plot_convergence(results)
    for suffix in ("png", "svg"):
        figure.savefig(out / f"convergence.{suffix}", dpi=160)


def _report(results: Sequence[MeshResult], out: Path | None) -> Report:
    errors = ("stress_error", "force_error", "marker_error")
    rows = [asdict(result) | {name: 100 * getattr(result, name) for name in errors} for result in results]
    note = "Errors are differences from the finest mesh."
    file = str(out / "convergence.csv") if out is not None else ""
    return Report(f"convergence at {results[-1].depth:.3g} mm", _COLUMNS, rows, (note,), file)
