"""`palpate recording take`: acquisition of a recording on a robot, manually or simulated."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from palpate.camera import open_source
from palpate.cli.flag import flags_of
from palpate.cli.output import JsonOutput, check_folder
from palpate.cli.progress import show_progress
from palpate.cli.unit import ModelFlags, UnitFlags
from palpate.core import PalpateError
from palpate.rig import TakeSpec

if TYPE_CHECKING:
    from palpate.design import Design
    from palpate.rig import NextImage, PlannedPress, RecordingFolder
    from palpate.sensor import Robot
    from palpate.surrogate import Twin

_OUT = "Folder of the recording: images, poses.csv and recording.json. The same command resumes it."
_ROBOT = (
    "Robot as NAME or NAME:TEXT: 'manual' (the user sets each pose with a goniometer or sine plate), 'simulated' (a "
    "unit on a simulated rig, by the twin), 'ur:HOST' (Universal Robots), 'ros2:HOST' (MoveIt by rosbridge), "
    "'tcp:HOST:PORT' (a server of text lines), or another package's robot."
)
_SOURCE = "Camera of the sensor: its number, or the text of another package's source; not with --robot simulated."
_SEED = "Random seed of the simulated unit and rig."
_SIMULATED = "simulated"
_CHANGING = {"dwell_s", "clear", "blank", "saturated", "buffered"}
"""Settings that may change when a recording is resumed."""


@Parameter(name="*")
@dataclass(frozen=True)
class RigFlags:
    """Robot, camera and seed of the simulated rig."""

    robot: Annotated[str, Parameter(help=_ROBOT)] = "manual"
    source: Annotated[str | None, Parameter(help=_SOURCE)] = None
    seed: Annotated[int, Parameter(help=_SEED)] = 0


def take(
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    *,
    rig: RigFlags = RigFlags(),
    spec: Annotated[TakeSpec, flags_of(TakeSpec, group="Presses")] = TakeSpec(),
    built: UnitFlags = UnitFlags(),
    reads: ModelFlags = ModelFlags(),
    output: JsonOutput = JsonOutput(),
) -> None:
    """Take a recording of presses of a flat wall.

    `palpate recording train`, `calibration identify` and `calibration accept` read it. At the start, the upright skin
    just touches the wall.
    """
    from palpate.rig import Acquisition, RecordingFolder, choose_next_press

    check_folder(out)
    if (rig.source is None) != (rig.robot == _SIMULATED):
        raise PalpateError(
            f"The rig {rig.robot} needs {'no --source: it has its own camera' if rig.source else 'a camera'}.",
            "Give --source for a robot or a manual rig, or --robot simulated without it.",
            code="options-exclusive",
        )
    unit = built.unit(reads.material)
    twin = _find_twin(reads, built) if spec.next or rig.robot == _SIMULATED else None
    design = unit.design
    settings = {
        "robot": rig.robot.partition(":")[0],
        "seed": rig.seed,
        "skin": design.skin.spec_data,
        "markers": design.layout.positions.tolist(),
        "camera": design.camera_spec.model_dump(mode="json"),
    }
    folder = RecordingFolder(out, settings | spec.model_dump(mode="json", exclude=_CHANGING))
    grid, table, taken = [] if spec.next else spec.grid(), out / "poses.csv", len(folder)

    def choose(number: int) -> PlannedPress:
        if twin is None or not spec.next:
            return grid[number]
        before = [(tilt, azimuth) for tilt, azimuth in folder.plan["presses"]]
        return choose_next_press(before, table, unit, twin, spec)

    count = spec.next or len(grid)
    with _open_rig(rig, spec, unit.design, twin, folder) as (robot, next_image), show_progress() as progress:
        folder.write_plan(robot=rig.robot, source=rig.source, **spec.model_dump(mode="json", include=_CHANGING))
        Acquisition(robot, next_image, unit.design.skin, folder, spec, progress).take(count, choose)
    new = len(folder) - taken
    facts = {"table": str(table), "images": len(folder), "new_images": new, "presses": count}
    output.show(facts, f"Images: {len(folder)} ({new} new). Presses: {count}. Table: {table}")


def _find_twin(reads: ModelFlags, built: UnitFlags) -> Twin:
    from palpate.sensor import open_model
    from palpate.surrogate import Twin

    twin = open_model(reads.find(built), built.unit().design.skin)
    if not isinstance(twin, Twin):
        raise PalpateError(
            f"--next and --robot simulated require a twin, and this is a trained model: {type(twin).__name__}.",
            "Give the twin of the design (.h5): `palpate calibration predict` makes it.",
            code="model-not-twin",
        )
    return twin


@contextmanager
def _open_rig(
    rig: RigFlags, spec: TakeSpec, design: Design, twin: Twin | None, folder: RecordingFolder
) -> Iterator[tuple[Robot, NextImage]]:
    """Open robot and camera; both are closed at the end of the block."""
    if twin is not None:
        tilt, deepest = float(twin.tilts_deg[-1]), twin.max_depth(spec.max_tilt_deg, 1.0)
        if spec.max_tilt_deg > tilt or spec.depth > deepest:
            raise PalpateError(
                f"The twin covers tilts up to {tilt:g}° and depths up to {deepest:.1f} mm at the maximum tilt.",
                "Lower --max-tilt or --depth.",
                code="twin-exceeded",
            )
    if twin is not None and rig.robot == _SIMULATED:
        from palpate.simulation import simulate_rig

        cell = simulate_rig(twin, design, spec.tool_length, rig.seed, len(folder))
        yield cell.robot, cell.next_image
        return
    from palpate.rig import images_of, open_robot

    # the end of the process from outside stops the robot, as Ctrl-C does
    ends = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    with ExitStack() as closed:
        for end in ends:
            closed.callback(signal.signal, end, signal.signal(end, signal.default_int_handler))
        robot = open_robot(rig.robot)
        closed.callback(robot.close)
        yield robot, images_of(closed.enter_context(open_source(rig.source or "")), spec.buffered)
