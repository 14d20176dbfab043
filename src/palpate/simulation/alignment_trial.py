"""Trials of the alignment of simulated units on a simulated robot to walls.

A unit is identified at a jig, mounted with an angular error, its tool offset is measured, and it is aligned to walls.
Units are drawn within the manufacturing tolerances; their images are rendered with the test bench's errors and pass
detection, assignment and fit. Walls differ in tilt, distance and friction.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from palpate.calibration import RobotUncertainty, ToleranceSpec, calibration_pose, sample_deviation
from palpate.core import FloatArray, PalpateError, atomic_write, generator, provenance
from palpate.core.report import write_csv
from palpate.design import Design, PoseDensity, rotation_vector, wall_normal
from palpate.sensor import (
    TOUCH_COLUMNS,
    Aligner,
    Alignment,
    AlignSpec,
    Placement,
    SensorSpec,
    Tool,
    Unit,
    describe_alignment,
    identify_unit,
    list_touches,
    open_sensor,
    rotation_from_vector,
)
from palpate.simulation.backend import SolverBackend, TwinBackend, UnitBackend
from palpate.simulation.simulated_cell import FlatWall, SimulatedCell, seat_unit
from palpate.simulation.simulated_robot import SimulatedRobot
from palpate.simulation.simulated_unit import SimulatedUnit
from palpate.simulation.spec import DEGRADED, SimulatedRobotSpec, WorkpieceSpec
from palpate.surrogate import Twin

WALLS = ToleranceSpec(friction_min=0.2, friction_max=10.0, lateral=0.2)
"""Tolerances of units, with friction of walls from 0.2 and lateral robot errors during a touch."""
_LENGTH_MM = 120.0
"""Distance from the flange to the centre of the skin's base. By hand."""
_STANDOFF_MM = 5.0
"""Distance from the assumed wall at the start of an alignment. By hand."""
_JIG = RobotUncertainty(0.02, 0.02)
_REFERENCE_DEG = 2.0
"""Tilt of the wall by which the tool offset is measured. By hand."""
_DEPTHS = (2.5, 4.0, 5.5)
"""Depths of these presses, mm. By hand."""


@dataclass(frozen=True, eq=False)
class AlignmentScenario:
    """Settings of an alignment trial.

    Attributes
    ----------
    twin
        The design's twin, the estimator.
    design
        Its markers and camera; skin and material for presses that are solved for each touch.
    align, robot, tolerance
        Alignment, errors of the robot, and tolerances of units and walls.
    workpiece
        Support of the walls, each of which rotates about a random axis under force.
    max_tilt_deg
        Maximum tilt of a wall.
    calibration_presses
        Presses at a jig by which each unit is identified; 0: none.
    by_solver
        Whether touches are solved by finite elements instead of the twin.
    seed
        Seed of units, walls and the robot's errors.
    """

    twin: Twin
    design: Design
    align: AlignSpec = field(default_factory=AlignSpec)
    robot: SimulatedRobotSpec = field(default_factory=SimulatedRobotSpec)
    tolerance: ToleranceSpec = WALLS
    workpiece: WorkpieceSpec = field(default_factory=WorkpieceSpec)
    max_tilt_deg: float = 10.0
    calibration_presses: int = 5
    by_solver: bool = False
    seed: int = 0


class AlignmentTrial(NamedTuple):
    """Alignment to one wall.

    Attributes
    ----------
    tilt_deg, friction
        Tilt of the wall relative to the drill at the start, and its friction.
    alignment
        Result of the aligner.
    final_deg
        True angle between drill and wall's normal at the end.
    clamped_deg
        The same under the clamping force.
    max_force_n
        Maximum true force.
    """

    tilt_deg: float
    friction: float
    alignment: Alignment
    final_deg: float
    clamped_deg: float
    max_force_n: float


class VirtualUnit:
    """Simulated unit, opened, identified if requested, mounted, with a measured tool offset.

    Parameters
    ----------
    scenario
        Settings.
    number
        Number of the unit, from 1.

    Attributes
    ----------
    deviation
        Manufacturing errors.
    tool
        Tool with the measured offset.
    offset_error_deg
        Angle between the measured and the true axis of the drill in the sensor's frame, degrees.
    offset_touches
        Number of touches of this measurement.

    Raises
    ------
    PalpateError
        If the sensor cannot be opened or identified, or the offset cannot be measured.
    """

    def __init__(self, scenario: AlignmentScenario, number: int) -> None:
        self.play, self.number = scenario, number
        self.deviation = sample_deviation(scenario.tolerance, scenario.seed, number)
        self._backend = self._choose_backend(SimulatedUnit(scenario.design, self.deviation, DEGRADED))
        unit = Unit(scenario.design, tolerance=scenario.tolerance)
        self._sensor = open_sensor([self._backend.unit.render_rest()], unit, scenario.twin, SensorSpec())
        if scenario.calibration_presses:
            self._identify()
        self._mount()

    def _choose_backend(self, unit: SimulatedUnit) -> UnitBackend:
        twin = self.play.twin
        if self.play.by_solver:
            return SolverBackend(unit, min(self.play.align.depth + 1.5, float(twin.depths_mm[-1])))
        return TwinBackend(unit, twin)

    def _identify(self) -> None:
        """Identify the unit from calibration presses at a jig; it then reads in the skin's frame."""
        rng, deepest = generator(self.play.seed, "jig", self.number), float(self.play.twin.depths_mm[-1])
        still = SimulatedRobotSpec(
            position_sd_mm=0.0, rotation_sd_deg=0.0, backlash_mm=0.0, backlash_deg=0.0, compliance=0.0, dropout=0.0
        )
        presses = []
        for press in range(self.play.calibration_presses):
            tilt, turn_deg = calibration_pose(press, float(self.play.twin.tilts_deg[-1]))
            truth = rotation_vector(tilt, np.radians(turn_deg + float(rng.uniform(0.0, 20.0))))
            poses, images = [], []
            off = rng.normal(0.0, [_JIG.tilt_deg, _JIG.tilt_deg, _JIG.depth])
            cell = self._cell(FlatWall(np.zeros(3), wall_normal(*np.radians(truth)), 1.0), Placement(), 0.0, rng)
            start = Placement(position=np.array([0.0, 0.0, -cell.depth_at(Placement())]))
            cell.robot = SimulatedRobot(start, still, rng, cell.push)
            for depth in _DEPTHS:
                if depth < deepest:
                    cell.robot.move(start.moved(np.array([0.0, 0.0, depth])))
                    image = cell.next_image()
                    assert not isinstance(image, PalpateError), "none is torn at the jig"
                    images.append(image)
                    poses.append(np.array([*truth, depth]) + off)
            presses.append((np.array(poses), images, np.full(len(poses), np.nan)))
        identify_unit(self._sensor, presses, _JIG, on_robot=False)

    def _cell(self, wall: FlatWall, mounted: Placement, unreadable: float, rng: np.random.Generator) -> SimulatedCell:
        return SimulatedCell(self._backend, wall, mounted, unreadable, rng)

    def _mount(self) -> None:
        """Mount the unit on the robot with an angular error, and measure its offset at a reference wall."""
        play, rng = self.play, generator(self.play.seed, "mount", self.number)
        askew = rotation_from_vector(rng.uniform(-play.robot.offset_deg, play.robot.offset_deg, 3))
        along = np.array([0.0, 0.0, _LENGTH_MM])
        self._mounted = Placement(askew @ seat_unit(self.deviation), along)
        nominal = Tool(Placement(position=along))
        tilt = rotation_vector(_REFERENCE_DEG, rng.uniform(0.0, 2.0 * np.pi))
        cell, robot = self._before(tilt, 1.0, rng)
        aligner = Aligner(robot, self._sensor, cell.next_image, nominal, play.align)
        self.tool = aligner.find_offset()
        self.offset_touches = 6
        true = self._mounted.rotation.T @ self.tool.drill
        self.offset_error_deg = _angle(true, self.tool.drill_in_sensor)

    def _before(
        self,
        tilt_deg: FloatArray,
        inverse_friction: float,
        rng: np.random.Generator,
        workpiece: WorkpieceSpec | None = None,
        axis_rad: float = 0.0,
    ) -> tuple[SimulatedCell, SimulatedRobot]:
        """Return a cell whose wall is tilted relative to the drill, and a robot in front of it."""
        spec = self.play.robot
        start = Placement(rotation_from_vector(rng.uniform(-180.0, 180.0) * np.array([0.0, 0.0, 1.0])))
        normal = start.rotation @ wall_normal(*np.radians(tilt_deg))
        across = np.cross(normal, start.rotation[:, 0])
        across /= np.linalg.norm(across)
        axis = np.cos(axis_rad) * across + np.sin(axis_rad) * np.cross(normal, across)
        wall = FlatWall(np.zeros(3), normal, inverse_friction, workpiece or WorkpieceSpec(), axis)
        cell = self._cell(wall, self._mounted, spec.dropout, rng)
        gap = _STANDOFF_MM + float(rng.uniform(-spec.approach_mm, spec.approach_mm))
        way = (start @ self._mounted).rotation[:, 2]
        start = start.moved(-(cell.depth_at(start) + gap) * way)
        cell.robot = SimulatedRobot(start, spec, rng, cell.push)
        return cell, cell.robot

    def square(self, wall: int) -> AlignmentTrial:
        """Align the drill to the wall of a number, which seeds its tilt, friction, distance and all errors."""
        play, rng = self.play, generator(self.play.seed, "wall", self.number, wall)
        tilt = float(PoseDensity.UNIFORM_DISC.radius(rng.uniform(), play.max_tilt_deg))
        tilts = rotation_vector(tilt, rng.uniform(0.0, 2.0 * np.pi))
        friction = play.tolerance.friction_at(float(rng.uniform()))
        about = float(generator(play.seed, "support", self.number, wall).uniform(0.0, 2.0 * np.pi))
        cell, robot = self._before(tilts, 1.0 / friction, rng, play.workpiece, about)
        aligner = Aligner(robot, self._sensor, cell.next_image, self.tool, play.align)
        said = aligner.align()
        forces = 0.0, play.workpiece.clamping_force
        final, clamped = (cell.angle_deg(self.tool.drill, force) for force in forces)
        return AlignmentTrial(tilt, friction, said, final, clamped, cell.max_force_n)


def _angle(first: FloatArray, second: FloatArray) -> float:
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second)))


def list_wall_touches(walls: Sequence[AlignmentTrial]) -> list[dict[str, Any]]:
    """Return one row per touch of every wall: ``wall`` (from 1) and `palpate.sensor.TOUCH_COLUMNS`."""
    return [{"wall": number, **row} for number, wall in enumerate(walls, 1) for row in list_touches(wall.alignment)]


def describe_wall(wall: AlignmentTrial) -> dict[str, Any]:
    """Return a simulated wall with its ground truth as plain data."""
    said = wall.alignment
    return {
        "tilt_deg": wall.tilt_deg,
        "friction": wall.friction,
        **describe_alignment(said),
        "final_deg": wall.final_deg,
        "clamped_deg": wall.clamped_deg,
        "max_force_n": wall.max_force_n,
        "held": bool(wall.final_deg <= said.residual_deg + said.residual_half_width_deg),
    }


def write_alignments(folder: Path, walls: Sequence[AlignmentTrial], facts: dict[str, Any]) -> None:
    """Write ``touches.csv``, a row a touch, and ``alignment.json``, an entry a wall, with `facts`.

    Raises
    ------
    PalpateError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "touches.csv", list_wall_touches(walls), ["wall", *TOUCH_COLUMNS])
    content = facts | {"walls": [describe_wall(wall) for wall in walls], "made_by": provenance()}
    with atomic_write(folder / "alignment.json") as draft:
        draft.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
