"""`palpate simulation align`: a drill that is squared to walls by touching them, on a simulated robot."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_folder
from palpate.cli.unit import DesignFlags, ModelFlags
from palpate.core import PalpateError
from palpate.core.report import Column, Report
from palpate.sensor import AlignSpec, Unit, check_model, list_touches, open_model
from palpate.simulation import (
    AlignmentScenario,
    AlignmentTrial,
    SimulatedRobotSpec,
    VirtualUnit,
    describe_wall,
    list_wall_touches,
    write_alignments,
)
from palpate.surrogate import Twin

_OUT = "Folder for touches.csv and alignment.json."
_WALLS = "Walls to square to, each of another tilt, friction and distance."
_NUMBER = "Which virtual unit, from 1; it decides what is not as designed about it."
_KNOWN = "Known presses at a jig by which the unit is identified first; 0: it is not."
_COLUMNS = (
    Column("wall"),
    Column("touch"),
    Column("rx_deg", form=".3f", meaning="estimated tilt about x", deciding=False),
    Column("ry_deg", form=".3f", meaning="estimated tilt about y", deciding=False),
    Column("depth_mm", form=".3f"),
    Column("angle_deg", form=".3f", meaning="estimated angle between tool and wall normal"),
    Column("half_width_deg", "half-width", form=".3f", meaning="half-width of the interval of the angle"),
    Column("turned_deg", form=".3f", meaning="turn of the tool after the touch"),
    Column("force_n", form=".3f"),
    Column("friction", form=".3f", meaning="estimated coefficient of friction; none if nothing slips"),
    Column("force_upper_n", "force, upper end", form=".3f", deciding=False),
    Column("images", meaning="images averaged", deciding=False),
)
_SEED = "Seed of units, walls and the robot's errors."


@Parameter(name="*")
@dataclass(frozen=True)
class AlignFlags:
    """Which unit is played, how many walls, and where to."""

    walls: Annotated[int, Parameter(help=_WALLS)] = 3
    unit_number: Annotated[int, Parameter(help=_NUMBER)] = 1
    calibration_presses: Annotated[int, Parameter(help=_KNOWN)] = 5
    seed: Annotated[int, Parameter(help=_SEED)] = 0
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None

    def check(self) -> None:
        """Refuse what cannot be played, with a `PalpateError`."""
        if self.walls < 1 or self.unit_number < 1 or not 0 <= self.calibration_presses <= 5 or self.seed < 0:
            raise PalpateError(
                f"{self.walls} walls, unit {self.unit_number}, {self.calibration_presses} known presses, "
                f"seed {self.seed}.",
                "Give 1 wall or more, a unit from 1, 0 to 5 known presses, and a seed of 0 or more.",
                code="option-out-of-bounds",
            )
        check_folder(self.out)


def align(
    *,
    design: DesignFlags = DesignFlags(),
    reads: ModelFlags = ModelFlags(),
    spec: Annotated[AlignSpec, flags_of(AlignSpec, group="Touches")] = AlignSpec(),
    robot: Annotated[
        SimulatedRobotSpec, flags_of(SimulatedRobotSpec, group="Simulated robot")
    ] = SimulatedRobotSpec(),
    run: AlignFlags = AlignFlags(),
    output: Output = Output(),
) -> None:
    """Touch, read, turn and touch again until a drill is square: a virtual unit on a simulated robot.

    On a robot of your own: `palpate.sensor.Aligner`.
    """
    run.check()
    designed = design.design(reads.material)
    twin = open_model(reads.find(design), designed.skin)
    if not isinstance(twin, Twin):
        raise PalpateError(
            "A network tells no force for a limit.",
            "Give the design's twin, see `palpate calibration predict`.",
            code="network-no-force",
        )
    check_model(twin, Unit(designed))
    play = AlignmentScenario(
        twin,
        designed,
        align=spec,
        robot=robot,
        calibration_presses=run.calibration_presses,
        seed=run.seed,
    )
    unit = VirtualUnit(play, run.unit_number)
    print(
        f"Tool's offset told by {unit.offset_touches} touches; it is off by {unit.offset_error_deg:.3f}°.",
        file=sys.stderr,
    )
    walls = [unit.square(number) for number in range(run.walls)]
    facts = {
        "align": spec.model_dump(mode="json"),
        "robot": robot.model_dump(mode="json"),
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
    output.show(facts | {"walls": described}, table, *map(_sentence, range(1, len(walls) + 1), walls))


def _sentence(number: int, wall: AlignmentTrial) -> str:
    estimate = wall.alignment
    return (
        f"Wall {number}: {estimate.outcome}; true residual angle {wall.final_deg:.3f}°, estimated "
        f"{estimate.residual_deg:.3f}° ± {estimate.residual_half_width_deg:.3f}°, maximum force "
        f"{wall.max_force_n:.3f} N."
    )
