"""`palpate calibration predict`: twins of designs, and predicted accuracy of their built units."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.bench import read_tolerance
from palpate.cli.border import keep_results
from palpate.cli.output import RESULTS, Output
from palpate.cli.progress import show_progress
from palpate.cli.run import WorkerFlags
from palpate.cli.unit import DesignFlags, MaterialFlags
from palpate.core import PalpateError
from palpate.core.report import Column, Report, write_csv
from palpate.study import MaterialSpec

if TYPE_CHECKING:
    from palpate.study import DesignAccuracy, Study
    from palpate.surrogate import Twin

_SOURCE = "YAML file of a study, or a preset: first, paper, best; by default the design of the flags."
_OUT = "Result folder; by default results/NAME, whose twins other commands find."
_KNOWN = "Calibration presses per unit in the second half of the table (1 to 100); default: the study's number, or 5."
_TOLERANCE = "Tolerances as NAME=VALUE, as for `palpate simulation bench`."
_COLUMNS = (
    Column("height_mm"),
    Column("thickness_mm"),
    Column("markers"),
    Column("calibration_presses", meaning="presses by which each unit was identified"),
    Column("rmse_deg", "angle RMSE", form="g", meaning="RMSE of rx and ry over all units"),
    Column("p95_deg", "95th percentile", form="g", meaning="95th percentile over units of the maximum error"),
    Column("depth_rmse_mm", "depth RMSE", form="g"),
    Column("noise_deg", form="g", deciding=False, meaning="RMSE of rx and ry by image noise alone"),
    Column("twin_error_mm", form="g", meaning="RMS distance of the twin from presses between its own"),
)
_MUCH_MM = 0.03
"""Interpolation error above which a twin errs by several times the marker noise, mm. By hand."""


@Parameter(name="*")
@dataclass(frozen=True)
class TwinFlags:
    """Design, material and units, instead of a study."""

    design: DesignFlags = DesignFlags()
    material: MaterialFlags = MaterialSpec()
    tolerance: Annotated[tuple[str, ...], Parameter(help=_TOLERANCE, negative="", consume_multiple=True)] = ()
    calibration_presses: Annotated[int | None, Parameter(help=_KNOWN)] = None

    def study(self, source: str | None) -> Study:
        """Return the named study, or the study of these flags, with the settings of its built units."""
        from palpate.study import AsBuiltSpec, read_study, single_design_study

        if source is None:
            study = single_design_study(self.design.skin_spec(), self.design.markers, self.material)
        elif TwinFlags(self.design, self.material) == TwinFlags():
            study = read_study(source)
        else:
            raise PalpateError(
                f"The study {source} and flags of a design exclude each other.",
                "Give a study, or flags of a design.",
                code="options-exclusive",
            )
        asked = study.built or AsBuiltSpec()
        tolerance = read_tolerance(self.tolerance) if self.tolerance else asked.tolerance
        built = asked.model_copy(
            update={
                "calibration_presses": self.calibration_presses or asked.calibration_presses,
                "tolerance": tolerance,
            }
        )
        return study.model_copy(update={"built": built})


def twin(
    source: Annotated[str | None, Parameter(help=_SOURCE)] = None,
    *,
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    worker_flags: WorkerFlags = WorkerFlags(),
    flags: TwinFlags = TwinFlags(),
    output: Output = Output(),
) -> int:
    """Make the twin of a design, or of every skin of a study, and predict the errors of built units.

    Each skin is pressed at tilts in steps of 4 degrees with five contact laws. No estimator is trained.
    Results in the result folder are reused.
    """
    from palpate.study import run_twins

    if flags.calibration_presses is not None and not 1 <= flags.calibration_presses <= 100:
        raise PalpateError(
            f"--calibration-presses is {flags.calibration_presses}.",
            "Give 1 to 100 calibration presses.",
            code="option-out-of-bounds",
        )
    worker_flags.check()
    study = flags.study(source)
    folder = keep_results(out or RESULTS / study.name)
    with show_progress() as progress:
        found = run_twins(study, folder, worker_flags.workers, progress)
    rows = [row for design in found for row in _rows(design)]
    _keep(folder / "twins", found, rows)
    table = Report(f"{study.name}: built units", _COLUMNS, rows, file=str(folder / "twins" / "built.csv"))
    output.show({"out": str(folder / "twins"), "designs": rows}, table, f"Twins: {folder / 'twins'}")
    for made in (_read(path) for path in dict.fromkeys(design.twin for design in found if design.twin)):
        if made.left_out:
            print(
                f"The twin of {made.skin.name} omits {', '.join(made.left_out)}: its presses have no derivative "
                "by it. The figures do not include such deviations, and calibration does not estimate them.",
                file=sys.stderr,
            )
        if made.interpolation_error_mm > _MUCH_MM:
            print(
                f"The twin of {made.skin.name} has an interpolation error of {made.interpolation_error_mm:.2f} mm "
                "between its presses, which the figures do not fully include. "
                "Add contact laws or tilts, or refine the mesh.",
                file=sys.stderr,
            )
    failed = [design for design in found if design.problem]
    for design in failed:
        print(f"{design.design.skin.name}, {len(design.design.layout)} markers: {design.problem}", file=sys.stderr)
    return 1 if failed else 0


@cache
def _read(path: Path) -> Twin:
    from palpate.surrogate import read_twin

    return read_twin(path)


def _rows(design: DesignAccuracy) -> list[dict[str, Any]]:
    return [
        {
            "height_mm": design.design.skin.height,
            "thickness_mm": design.design.skin.thickness,
            "markers": len(design.design.layout),
            "calibration_presses": figure.calibration_presses,
            "rmse_deg": round(figure.rmse_deg, 4),
            "p95_deg": round(figure.p95_deg, 4),
            "depth_rmse_mm": round(figure.depth_rmse, 4),
            "noise_deg": round(figure.noise_deg, 4),
            "twin_error_mm": round(_read(design.twin).interpolation_error_mm, 4) if design.twin else None,
            "left_out": list(_read(design.twin).left_out) if design.twin else [],
        }
        for figure in design.accuracies
    ]


def _keep(folder: Path, designs: tuple[DesignAccuracy, ...], rows: list[dict[str, Any]]) -> None:
    """Write the twins under readable names, and the table."""
    from palpate.study import export_twins

    folder.mkdir(parents=True, exist_ok=True)
    export_twins(
        folder.parent, ((design.design.skin_spec, design.twin) for design in designs if design.twin is not None)
    )
    write_csv(folder / "built.csv", rows, [column.name for column in _COLUMNS])
