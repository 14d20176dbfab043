"""`palpate study`: show, plot, export and compare specification grids of finished studies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from palpate.cli.output import JsonOutput, Output
from palpate.core.report import Column, Report

if TYPE_CHECKING:
    from palpate.study import Comparison, SpecificationGrid

Directory = Annotated[Path, Parameter(help="Result folder of a study, with its grid.")]
Where = Annotated[str | None, Parameter(help="Keep rows, e.g. 'markers >= 91 and rmse_deg < 0.5'.")]
Sort = Annotated[
    str | None,
    Parameter(
        allow_leading_hyphen=True,
        help="Column to sort by; a leading minus reverses. By default the RMSE as built, otherwise that with jitter.",
    ),
]


def show(directory: Directory, *, where: Where = None, sort: Sort = None, output: Output = Output()) -> None:
    """Show the grid of a result folder, its rows filtered and sorted."""
    from palpate.study import grid_report

    rows = _choose(directory, where, sort).designs
    output.show(rows, grid_report(rows, title=str(directory), file=str(directory / "grid.csv")))


def plot(
    directory: Directory,
    *,
    metric: Annotated[str | None, Parameter(help="Column to draw; by default rmse_deg or travel_mm.")] = None,
    kind: Annotated[
        Literal["heat", "travel", "depth", "tilt", "markers"],
        Parameter(help="Heat maps over height and thickness, or curves against thickness, depth, tilt or markers."),
    ] = "heat",
    out: Annotated[
        Path | None, Parameter(name=["--out", "-o"], help="Folder of the figures; by default DIRECTORY.")
    ] = None,
    where: Where = None,
    output: JsonOutput = JsonOutput(),
) -> None:
    """Draw one metric of a grid as PNG and SVG."""
    from palpate.study import plot_grid, ranking_column

    grid = _choose(directory, where, None)
    first = {"travel": "travel_mm", "depth": "rmse_deg", "tilt": "rmse_deg"}
    paths = plot_grid(grid, kind, metric or first.get(kind) or ranking_column(grid.columns), out or directory)
    files = [str(path) for path in paths]
    output.show({"files": files}, *files)


def export(
    directory: Directory,
    *,
    to: Annotated[Path, Parameter(help="File that ends in .csv, .parquet or .md.")],
    where: Where = None,
    sort: Sort = None,
    output: JsonOutput = JsonOutput(),
) -> None:
    """Write a grid as CSV, Parquet or Markdown for other programs."""
    from palpate.study import export_grid

    grid = _choose(directory, where, sort)
    files = [str(path) for path in export_grid(to, grid)]
    output.show({"files": files, "designs": len(grid.designs)}, f"{', '.join(files)}: {len(grid.designs)} designs")


def model(
    directory: Directory,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"], help="File to write, e.g. best.onnx.")],
    where: Where = None,
    sort: Sort = None,
    output: JsonOutput = JsonOutput(),
) -> None:
    """Write the trained estimator of the first design, after filter and sorting, as an ONNX file."""
    from palpate.study import copy_model

    design = copy_model(directory, _choose(directory, where, sort), out)
    output.show({"file": str(out), "design": design}, f"{out}: {design}")


def compare(
    first: Directory,
    second: Directory,
    *,
    metric: Annotated[
        tuple[str, ...] | None, Parameter(negative="", help="Columns to compare; by default the main errors.")
    ] = None,
    output: Output = Output(),
) -> None:
    """Compare two grids: ratios of equal designs, and differences of spec, seeds and versions."""
    from palpate.study import compare_grids, read_grid

    comparison = compare_grids(read_grid(first), read_grid(second), *([metric] if metric else []))
    output.show(_describe(comparison), *_reports(comparison, (str(first), str(second))))


def _choose(directory: Path, where: str | None, sort: str | None) -> SpecificationGrid:
    """Return the grid of a folder with its designs filtered and sorted, the best first."""
    from palpate.study import filter_rows, ranking_column, read_grid, sort_rows

    grid = read_grid(directory)
    rows = grid.designs if where is None else filter_rows(grid.designs, where)
    return grid.select(sort_rows(rows, sort or ranking_column(grid.columns)))


def _reports(comparison: Comparison, names: tuple[str, str]) -> Iterator[Report | str]:
    from palpate.study import grid_column

    yield f"A is {names[0]}, B is {names[1]}."
    columns = [grid_column(name) for name in ("height_mm", "thickness_mm", "markers")]
    for number, metric in enumerate(comparison.metrics):
        one, first = grid_column(metric), number == 0
        columns += [
            Column(f"{metric}_{side}", f"{one.title} {side.upper()}", one.measure, one.form, deciding=first)
            for side in "ab"
        ]
        columns.append(Column(f"{metric}_ratio", f"{one.title} B/A", "", deciding=first))
    yield Report("designs in A and B", columns, comparison.rows)
    yield from _moved(comparison)
    for name, rows in zip("AB", (comparison.only_first, comparison.only_second), strict=True):
        designs = ", ".join(f"H{r['height_mm']:g} T{r['thickness_mm']:g} {r['markers']}" for r in rows)
        if designs:
            yield f"Only {name} has {designs}."
    differences = [(item.name, item.first, item.second) for item in comparison.differences]
    heads = (Column("name"), Column("A", prose=True), Column("B", prose=True))
    yield Report.of("differences", heads, differences) if differences else "Spec, seeds and versions are the same."


def _moved(comparison: Comparison) -> Iterator[str]:
    """Yield sentences on the rows that differ by more than the spread over repeats."""
    for row in comparison.moved:
        design = f"H{row['height_mm']:g} T{row['thickness_mm']:g} {row['markers']}"
        yield f"{design} moved: rmse_deg by {row['moved']:+.1f} standard deviations of its spread over repeats."
    judged = sum(row["moved"] is not None for row in comparison.rows)
    if judged and not comparison.moved:
        yield f"{judged} rows differ by no more than the spread over repeats."


def _describe(comparison: Comparison) -> dict[str, Any]:
    return {
        "designs": comparison.rows,
        "moved": comparison.moved,
        "only_a": comparison.only_first,
        "only_b": comparison.only_second,
        "differences": [{"name": item.name, "a": item.first, "b": item.second} for item in comparison.differences],
    }
