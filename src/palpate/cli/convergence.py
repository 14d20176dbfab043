"""`palpate convergence`: one press on finer and finer meshes, as the paper's Fig. 9."""

from __future__ import annotations

import csv
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.cli.compiling import announce_compilation
from palpate.cli.flag import JsonFlag, flags_of
from palpate.cli.output import check_folder, print_json, print_table
from palpate.cli.press import PressFlags
from palpate.design import MarkerSpec, place_markers
from palpate.fea import CELLS, MeshResult, Press, plot_convergence, study_convergence
from palpate.mesh import MeshSpec

_CELLS = "Cells from pole to rim of each mesh."
_MARKERS = "Markers that are followed on every mesh."
_OUT = "Folder for convergence.csv, .png and .svg; without it, only the table is printed."


@Parameter(name="*")
@dataclass(frozen=True)
class RefinedFlags(PressFlags):
    """A press whose meshes `--meshes` tells."""

    mesh: Annotated[MeshSpec, flags_of(MeshSpec, without="cells", group="Mesh")] = MeshSpec()


def convergence(
    *,
    flags: RefinedFlags = RefinedFlags(),
    meshes: Annotated[tuple[int, ...], Parameter(help=_CELLS, consume_multiple=True)] = CELLS,
    markers: Annotated[int, Parameter(help=_MARKERS)] = 169,
    out: Annotated[Path | None, Parameter(help=_OUT)] = None,
    json: JsonFlag = False,
) -> None:
    """Press one dome on finer and finer meshes: greatest stress, force and markers against the number of elements."""
    points = place_markers(flags.build(), MarkerSpec(count=markers)).positions
    check_folder(out)
    announce_compilation()
    results = study_convergence(*flags.problem(), points, meshes, _print_mesh)
    if out is not None:
        _write_results(out, results)
    if json:
        print_json([asdict(result) for result in results])
    else:
        _print_results(results)


def _print_mesh(cells: int, press: Press) -> None:
    print(f"{cells} cells: {press.ended}, {press.cpu_s:.1f} CPU-seconds", file=sys.stderr)


def _write_results(out: Path, results: Sequence[MeshResult]) -> None:
    out.mkdir(parents=True, exist_ok=True)
    with (out / "convergence.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([field.name for field in fields(MeshResult)])
        writer.writerows([[f"{value:.6g}" for value in asdict(result).values()] for result in results])
    figure = plot_convergence(results)
    for suffix in ("png", "svg"):
        figure.savefig(out / f"convergence.{suffix}", dpi=160)


def _print_results(results: Sequence[MeshResult]) -> None:
    columns = ["cells", "elements", "unknowns", "stress MPa", "error %", "force N", "error %", "markers rms %"]
    rows = [
        [
            str(result.cells),
            str(result.elements),
            str(result.unknowns),
            f"{result.peak_stress:.4f}",
            f"{100 * result.stress_error:+.2f}",
            f"{result.force:.4f}",
            f"{100 * result.force_error:+.2f}",
            f"{100 * result.marker_error:.3f}",
        ]
        for result in results
    ]
    print_table(f"convergence at {results[-1].depth:.3g} mm", columns, rows)
    print("Errors are against the finest mesh; markers over the depth.")
