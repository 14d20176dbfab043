"""`palpate calibration identify`: identification of a built unit from calibration presses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import read_image
from palpate.cli.column_flags import ColumnFlags
from palpate.cli.output import Output, check_file, check_folder
from palpate.cli.unit import ModelFlags, UnitFlags, open_printing_scale
from palpate.core import PalpateError
from palpate.core.report import Column, Report

if TYPE_CHECKING:
    from palpate.calibration import RobotUncertainty

_COLUMNS = (
    Column("name", "parameter"),
    Column("unit"),
    Column("mean", form=".6g", meaning="mean of the posterior, to the second digit of its standard deviation"),
    Column("sd", "standard deviation", form=".2g", meaning="standard deviation of the posterior"),
    Column("before", "prior standard deviation", form=".2g"),
)
_TRUTH = (
    "Table of the known poses: columns image, press, rx_deg, ry_deg, depth_mm and, with a load cell, force_n; in the "
    "folder of its images. Images of the unloaded skin have the press 'rest'."
)
_OUT = "Unit file (.json) for `palpate sensor live` and `palpate calibration accept`."
_REPORT = "Folder for a report with figures: estimated parameters, and the most informative next press."
_TILT = "Standard deviation of the robot's tilts, degrees (> 0, <= 5)."
_DEPTH = "Standard deviation of the robot's depths, mm (> 0, <= 5)."
_FORCE = "Standard deviation of the load cell's readings, N (> 0, <= 5)."


@Parameter(name="*")
@dataclass(frozen=True)
class IdentificationFlags:
    """Unit file and report folder."""

    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None
    report: Annotated[Path | None, Parameter(help=_REPORT)] = None


@Parameter(name="*")
@dataclass(frozen=True)
class RobotFlags:
    """Columns and standard deviations of the robot's poses and of the load cell."""

    robot_tilt: Annotated[float, Parameter(help=_TILT)] = 0.02
    robot_depth: Annotated[float, Parameter(help=_DEPTH)] = 0.02
    robot_force: Annotated[float, Parameter(help=_FORCE)] = 0.005
    columns: ColumnFlags = ColumnFlags()

    def spec(self) -> RobotUncertainty:
        """Return the robot uncertainty of these flags."""
        from palpate.calibration import RobotUncertainty

        return RobotUncertainty(self.robot_tilt, self.robot_depth, self.robot_force)

    def check(self) -> None:
        """Raise a `PalpateError` if a standard deviation is out of bounds."""
        if not (0 < self.robot_tilt <= 5 and 0 < self.robot_depth <= 5 and 0 < self.robot_force <= 5):
            raise PalpateError(
                f"The robot's standard deviations are {self.robot_tilt:g}°, {self.robot_depth:g} mm and "
                f"{self.robot_force:g} N.",
                "Give values above 0 and at most 5.",
                code="option-out-of-bounds",
            )


def identify(
    truth: Annotated[Path, Parameter(help=_TRUTH)],
    *,
    reads: ModelFlags = ModelFlags(),
    files: IdentificationFlags = IdentificationFlags(),
    built: UnitFlags = UnitFlags(),
    robot: RobotFlags = RobotFlags(),
    output: Output = Output(),
) -> None:
    """Estimate the deviations of a unit and its mounting on the robot from calibration presses."""
    from palpate.calibration import IdentifiedUnit, write_unit
    from palpate.sensor import identify_unit, open_model, read_ground_truth, write_identification

    check_file(files.out, ".json")
    check_folder(files.report)
    robot.check()
    known = read_ground_truth(truth, robot.columns.mapping()).locate(truth.parent)
    unit = built.unit(reads.material)
    model = open_model(reads.find(built), unit.design.skin)
    sensor = open_printing_scale([read_image(Path(name)) for name in known.rest], unit, model)
    presses = list(known.presses())
    found = identify_unit(sensor, presses, robot.spec())
    if files.out is not None:
        write_unit(
            files.out,
            IdentifiedUnit(
                unit.design.skin.spec_data, unit.design.layout.positions, found.posterior, found.mounting, found.scale
            ),
        )
    if files.report is not None:
        write_identification(files.report, found, sensor, robot.spec())
    rows = found.rows(unit.tolerance)
    written = str(files.out) if files.out else None
    output.show(
        {
            "known": rows,
            "misfit": found.misfit,
            "left_out": list(found.left_out),
            "presses": len(presses),
            "out": written,
        },
        Report(f"{unit.design.skin.name}, {len(presses)} presses", _COLUMNS, [_rounded(row) for row in rows]),
        f"RMS marker residual: {found.misfit**0.5:.2f} times the noise."
        + (
            f" Not estimated, as the twin has no derivative by it: {', '.join(found.left_out)}."
            if found.left_out
            else ""
        )
        + (f" Unit: {written}" if written else ""),
    )


def _rounded(row: dict[str, Any]) -> dict[str, Any]:
    digits = 1 - math.floor(math.log10(row["sd"])) if row["sd"] > 0 else 6
    return row | {"mean": round(row["mean"], digits)}
