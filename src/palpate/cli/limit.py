"""`palpate design bound`: lower bounds on the error of any estimator of a design, without training."""

from __future__ import annotations

import sys
from collections.abc import Container, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.border import keep_results
from palpate.cli.output import RESULTS, OutFlag, Output
from palpate.cli.progress import show_progress
from palpate.core import PalpateError
from palpate.core.report import Column, Report

if TYPE_CHECKING:
    from palpate.study import DesignBounds, Row

_SOURCE = "YAML file of a study, a preset (first, paper, best), or the result folder of a finished study."
_COLUMNS = (
    Column("height_mm"),
    Column("thickness_mm"),
    Column("markers"),
    Column("depth_mm", form="g"),
    *(
        column
        for unit in ("deg", "mm")
        for column in (
            Column(f"least_squares_{unit}", "least-squares bound", form=".3f", meaning="bound of least-squares fits"),
            Column(f"pitman_{unit}", "Pitman bound", form=".3f", meaning="error of the posterior mean"),
            Column(f"floor_{unit}", "bound of any estimator", form=".3f"),
        )
    ),
)


def limit(
    source: Annotated[str, Parameter(help=_SOURCE)],
    *,
    out: OutFlag = None,
    workers: Annotated[
        int | None, Parameter(help="Number of worker processes; by default one per core, if memory suffices.")
    ] = None,
    output: Output = Output(),
) -> int:
    """Compute lower error bounds of any estimator, by design and depth, from the simulated Jacobian.

    Presses in the result folder are reused, and missing presses are solved. No estimator is trained.
    """
    folder = Path(source)
    designs = _read(folder) if folder.is_dir() else _compute(source, out, workers)
    output.show({"designs": designs}, _report(source, designs))
    failed = [design for design in designs if design["failure"]]
    for design in failed:
        name = f"H{design['height_mm']:g} T{design['thickness_mm']:g} {design['markers']} markers"
        print(f"{name}: {design['failure']}", file=sys.stderr)
    return 1 if failed else 0


def _compute(source: str, out: Path | None, workers: int | None) -> list[dict[str, Any]]:
    from palpate.study import available_cores, read_study, run_bounds

    study = read_study(source)
    if workers is not None and not 1 <= workers <= 1024:
        raise PalpateError(
            f"--workers is {workers}.",
            f"Give 1 to 1024; this machine has {available_cores()} cores.",
            code="option-out-of-bounds",
        )
    unit = "deg" if study.obstacle.pose_space.is_tilt else "mm"
    folder = keep_results(out or RESULTS / study.name)
    with show_progress() as progress:
        return [_describe(design, unit) for design in run_bounds(study, folder, workers, progress)]


def _describe(design: DesignBounds, unit: str) -> dict[str, Any]:
    from palpate.learn import pool_bounds

    pooled = pool_bounds(design.limits)
    bounds = [asdict(bound) for bound in design.limits]
    return {
        "height_mm": design.design.skin.height,
        "base_radius_mm": design.design.skin.base_radius,
        "thickness_mm": design.design.skin.thickness,
        "markers": len(design.design.layout),
        f"bound_{unit}": pooled.least_squares_deg if pooled else None,
        f"bound_pitman_{unit}": pooled.pitman_deg if pooled else None,
        "by_depth": [_in_unit(bound, unit) for bound in bounds],
        "failure": design.failure,
    }


def _in_unit(bound: dict[str, Any], unit: str) -> dict[str, Any]:
    """Rename the keys of a bound by the unit of the estimated position."""
    return {f"{name.removesuffix('_deg')}_{unit}" if name.endswith("_deg") else name: bound[name] for name in bound}


def _unit(columns: Container[str]) -> str:
    """Return the unit of the estimated position, by the columns of a table."""
    return "mm" if "bound_mm" in columns else "deg"


def _read(folder: Path) -> list[dict[str, Any]]:
    """Return the bounds in the grid of a finished study."""
    from palpate.study import read_grid, rows_for_design

    grid = read_grid(folder)
    bound = f"bound_{_unit(grid.columns)}"
    if all(row[bound] is None for row in grid.by_depth):
        raise PalpateError(
            f"The grid of {folder} contains no error bounds.",
            "Give the study's YAML file, or run the study again.",
            code="grid-no-limits",
        )
    return [_describe_row(row, rows_for_design(grid.by_depth, number)) for number, row in enumerate(grid.designs)]


def _describe_row(row: Row, depths: Sequence[Row]) -> dict[str, Any]:
    unit = _unit(row)
    names = ("height_mm", "base_radius_mm", "thickness_mm", "markers", f"bound_{unit}", f"bound_pitman_{unit}")
    by_depth = [
        {
            "depth_mm": at["depth_mm"],
            f"least_squares_{unit}": at[f"bound_{unit}"],
            f"pitman_{unit}": at[f"bound_pitman_{unit}"],
            f"floor_{unit}": at[f"bound_floor_{unit}"],
        }
        for at in depths
        if at[f"bound_{unit}"] is not None
    ]
    return {
        **{name: row[name] for name in names},
        "by_depth": by_depth,
        "failure": "" if by_depth else row["failure"],
    }


def _report(title: str, designs: list[dict[str, Any]]) -> Report:
    rows = []
    for design in designs:
        rows += [{**design, **bound} for bound in design["by_depth"]]
        unit = _unit(design)
        if design[f"bound_{unit}"] is not None:
            names = {f"least_squares_{unit}": f"bound_{unit}", f"pitman_{unit}": f"bound_pitman_{unit}"}
            pooled = {name: design[found] for name, found in names.items()}
            rows.append({**design, **pooled, "depth_mm": "all"})
    return Report(title, _COLUMNS, rows)
