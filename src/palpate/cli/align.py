"""`palpate simulation align`: alignment of a tool normal to walls by presses, on a simulated robot."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_folder
from palpate.cli.unit import DesignFlags, ModelFlags
from palpate.core import PalpateError
from palpate.core.report import Column, Report
from palpate.sensor import AlignSpec
from palpate.simulation import SimulatedRobotSpec, WorkpieceSpec

if TYPE_CHECKING:
    from palpate.simulation import AlignmentTrial

_OUT = "Folder for touches.csv and alignment.json."
_WALLS = "Number of walls; each has its own tilt, friction and distance."
_NUMBER = "Number of the simulated unit, from 1; it determines the deviations of the unit from the design."
_KNOWN = "Calibration presses by which the unit is identified first, 0 to 5; 0: the unit is not identified."
_COLUMNS = (
    Column("wall"),
    Column("touch"),
    Column("rx_deg", form=".3f", meaning="estimated tilt about x", deciding=False),
    Column("ry_deg", form=".3f", meaning="estimated tilt about y", deciding=False),
    Column("depth_mm", form=".3f"),
    Column("angle_deg", form=".3f", meaning="estimated angle between tool and wall normal"),
    Column("half_width_deg", "half-width", form=".3f", meaning="half-width of the interval of the angle"),
    Column("turned_deg", form=".3f", meaning="rotation of the tool after the press"),
    Column("force_n", form=".3f"),
    Column("friction", form=".3f", meaning="estimated coefficient of friction; empty without slip"),
    Column("force_upper_n", "force, upper end", form=".3f", deciding=False),
    Column("images", meaning="images averaged", deciding=False),
)
_SEED = "Random seed of units, walls and robot errors."


@Parameter(name="*")
@dataclass(frozen=True)
class AlignFlags:
    """Simulated unit, number of walls and their support, seed and output folder."""

    workpiece: Annotated[WorkpieceSpec, flags_of(WorkpieceSpec, group="Workpiece")] = WorkpieceSpec()
    walls: Annotated[int, Parameter(help=_WALLS)] = 3
    unit_number: Annotated[int, Parameter(help=_NUMBER)] = 1
    calibration_presses: Annotated[int, Parameter(help=_KNOWN)] = 5
    seed: Annotated[int, Parameter(help=_SEED)] = 0
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None

    def check(self) -> None:
        """Raise a `PalpateError` if a number is out of bounds or the folder cannot be written."""
        if self.walls < 1 or self.unit_number < 1 or not 0 <= self.calibration_presses <= 5 or self.seed < 0:
            raise PalpateError(
                f"{self.walls} walls, unit {self.unit_number}, {self.calibration_presses} calibration presses or "
                f"seed {self.seed} is out of bounds.",
                "Give at least 1 wall, a unit from 1, 0 to 5 calibration presses, and a seed from 0.",
                code="option-out-of-bounds",
            )
        check_folder(self.out)


def align(
    *,
    design: DesignFlags = DesignFlags(),
    reads: ModelFlags = ModelFlags(),
    spec: Annotated[AlignSpec, flags_of(AlignSpec, group="Alignment")] = AlignSpec(),
    robot: Annotated[
        SimulatedRobotSpec, flags_of(SimulatedRobotSpec, group="Simulated robot")
    ] = SimulatedRobotSpec(),
    run: AlignFlags = AlignFlags(),
    output: Output = Output(),
) -> None:
    """Align a tool normal to walls by repeated presses: a simulated unit on a simulated robot.

    For a real robot, use `palpate.sensor.Aligner` in Python.
    """
    from palpate.sensor import Unit, check_model, list_touches, open_model
    from palpate.simulation import AlignmentScenario, VirtualUnit, describe_wall, list_wall_touches, write_alignments
    from palpate.surrogate import Twin

    run.check()
    designed = design.design(reads.material)
    twin = open_model(reads.find(design), designed.skin)
    if not isinstance(twin, Twin):
        raise PalpateError(
            "The force limit is computed from a twin, and this model is a trained network.",
            "Give the twin of the design (.h5): `palpate calibration predict` makes it.",
            code="network-no-force",
        )
    check_model(twin, Unit(designed))
    play = AlignmentScenario(
        twin,
        designed,
        align=spec,
        robot=robot,
        workpiece=run.workpiece,
        calibration_presses=run.calibration_presses,
        seed=run.seed,
    )
    unit = VirtualUnit(play, run.unit_number)
    print(
        f"Rotation offset of the tool estimated from {unit.offset_touches} presses; "
        f"its error is {unit.offset_error_deg:.3f}°.",
        file=sys.stderr,
    )
    walls = [unit.square(number) for number in range(run.walls)]
    facts = {
        "align": spec.model_dump(mode="json"),
        "robot": robot.model_dump(mode="json"),
        "workpiece": run.workpiece.model_dump(mode="json"),
        "unit": unit.deviation.as_dict(),
        "calibration_presses": run.calibration_presses,
        "seed": run.seed,
        "offset_error_deg": unit.offset_error_deg,
        "images_by": "the twin of the design",
    }
    if run.out is not None:
        write_alignments(run.out, walls, facts)
    described = [describe_wall(wall) | {"each": list_touches(wall.alignment)} for wall in walls]
    file = str(run.out / "touches.csv") if run.out is not None else ""
    table = Report("touches", _COLUMNS, list_wall_touches(walls), file=file)
    sentences = (_sentence(number, wall, run.workpiece) for number, wall in enumerate(walls, 1))
    output.show(facts | {"walls": described}, table, *sentences)


def _sentence(number: int, wall: AlignmentTrial, workpiece: WorkpieceSpec) -> str:
    estimate = wall.alignment
    clamp = workpiece.clamping_force
    return (
        f"Wall {number}: {estimate.outcome}; true residual angle {wall.final_deg:.3f}°, estimated "
        f"{estimate.residual_deg:.3f}° ± {estimate.residual_half_width_deg:.3f}°, maximum force "
        f"{wall.max_force_n:.3f} N" + (f"; {wall.clamped_deg:.3f}° clamped by {clamp:g} N." if clamp else ".")
    )
