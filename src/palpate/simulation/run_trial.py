"""Simulated test bench: built units are pressed, imaged and read by the real processing chain.

A unit deviates from its design within the manufacturing tolerances. Its presses are solved on another mesh than those
of the training (or by CalculiX), at tilts, directions and depths that no training image has. Rendered images go
through detection, assignment, registration and the model, which use the design only.

The robot's frame is the frame of the ground truth. The seating of the skin and the depth of first contact are unknown
to the robot; the latter is measured, if requested, by one press in advance (`palpate.sensor.depth_zero`).

Every press and every simulated unit is an artefact of a store, so that an interrupted bench resumes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.calibration import Deviation, RobotUncertainty, calibration_pose
from palpate.core import ArtefactStore, FloatArray, PalpateError, Recipe, generator, provenance, stage_version
from palpate.design import (
    TILT_SPACE,
    Design,
    PoseDensity,
    rotation_vector,
    wall_normal,
)
from palpate.fea import (
    PRESS_SOLVERS,
    Branch,
    Press,
    WallSpec,
    calculix_recipe,
    press_recipe,
    read_press,
    solve_press,
    write_press,
)
from palpate.learn import Predictor
from palpate.mechanics import EndReason, SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import (
    Sensor,
    Unit,
    check_model,
    find_depth_zero,
    identify_unit,
    open_model,
    open_sensor,
)
from palpate.simulation.simulated_unit import SimulatedUnit
from palpate.simulation.spec import VirtualBenchSpec
from palpate.simulation.trial import (
    COLUMNS,
    MEASURANDS,
    ParameterEstimate,
    UnitTrial,
    compare_parameters,
    read_trial,
    write_trial,
)
from palpate.surrogate import Twin

FINER = 9.0 / 8.0
"""Cells along a meridian of a built unit's presses, over those of the training. By hand."""
_INVERTED_CORE = 2
"""Core of the meshes of inverted units (see `palpate.study.accuracy_task`)."""


@dataclass(frozen=True, eq=False)
class VirtualBench:
    """Configuration of a simulated test bench.

    Attributes
    ----------
    spec
        Presses, images and evaluation.
    design
        The design; the training assumed its camera and elastomer.
    model
        The estimator: a trained network (.onnx), or the design's twin (.h5).
    store
        Store of presses and results.
    model_key
        Key of the model's artefact, part of the key of results; empty: the hash of its file.
    """

    spec: VirtualBenchSpec
    design: Design
    model: Path
    store: ArtefactStore
    model_key: str = ""

    @cached_property
    def opened_model(self) -> Predictor | Twin:
        """The opened model."""
        return open_model(self.model)

    @property
    def name(self) -> str:
        """Label of the design."""
        skin = self.design.skin
        return f"H {skin.height:g}, T {skin.thickness:g} mm, {len(self.design.layout)} markers"

    def facts(self) -> dict[str, Any]:
        """Header of every report, as JSON data: spec, design, model and versions."""
        return {
            "spec": self.spec.model_dump(mode="json"),
            "dome": self.design.skin_spec.model_dump(mode="json"),
            "markers": len(self.design.layout),
            "model_sha256": self.model_sha256,
            "made_by": provenance() | {"unit_trial": stage_version("unit_trial")},
        }

    def check(self) -> None:
        """Reject settings that no unit can be simulated with, before anything is solved.

        Raises
        ------
        PalpateError
            If the model cannot be opened, or is not of this design, or the skin is no body of revolution.
        """
        self.design.skin.require_revolution(
            "one press of a unit is turned to every azimuth",
            "Evaluate its estimator by `palpate run`, on held-out presses.",
        )
        check_model(self.opened_model, Unit(self.design), TILT_SPACE)

    @cached_property
    def model_sha256(self) -> str:
        """Identity of the model: its hash or key."""
        try:
            return hashlib.sha256(self.model.read_bytes()).hexdigest()
        except OSError as error:
            raise PalpateError(
                f"{self.model} cannot be read: {error.strerror}.",
                "Give an .onnx file or a twin.",
                code="file-unreadable",
            ) from error


def run_unit_trial(bench: VirtualBench, deviation: Deviation) -> UnitTrial:
    """Press, image and read one unit, or read its result from the store.

    Raises
    ------
    PalpateError
        If a press cannot be solved, or the model is not of this design.
    """
    recipe = unit_recipe(bench, deviation)
    found = bench.store.find(recipe, ".json")
    if found is None:
        trial = _run_unit(bench, deviation)
        found = bench.store.write(recipe, lambda path: write_trial(path, trial), ".json")
    return read_trial(found, deviation)


def unit_tilts(spec: VirtualBenchSpec, unit: int) -> list[float]:
    """Tilts of a unit's presses, degrees, ascending: one drawn from each equal part of the range."""
    parts = np.arange(spec.tilts) + generator(spec.seed, "tilts", unit).random(spec.tilts)
    return PoseDensity.UNIFORM_TILT.radius(parts / spec.tilts, spec.max_tilt_deg).round(3).tolist()


def solve_unit_presses(bench: VirtualBench, deviation: Deviation) -> Iterator[Press]:
    """Yield the unit's presses by ascending tilt; missing ones are solved."""
    for tilt in unit_tilts(bench.spec, deviation.unit):
        yield _press(bench, deviation, tilt, _branch(bench, deviation))


def _branch(bench: VirtualBench, deviation: Deviation) -> Branch:
    """Branch in which a unit is read."""
    other = bench.spec.inverted and deviation.unit > bench.spec.units - bench.spec.inverted
    return Branch.INVERTED if other else Branch.FLAT


def _press(bench: VirtualBench, deviation: Deviation, tilt: float, branch: Branch = Branch.FLAT) -> Press:
    recipe = _press_recipe(bench, deviation, tilt, branch)
    path = bench.store.find(recipe)
    if path is None:
        press = _solve(bench, deviation, tilt, branch)
        path = bench.store.write(recipe, lambda draft: write_press(draft, press))
    return read_press(path)


def _run_unit(bench: VirtualBench, deviation: Deviation) -> UnitTrial:
    simulated = SimulatedUnit(bench.design, deviation, bench.spec.render)
    unit = Unit(bench.design, tolerance=bench.spec.tolerance)
    presses = list(solve_unit_presses(bench, deviation))
    try:
        _refuse_none(presses)
        sensor = open_sensor([simulated.render_rest()], unit, bench.opened_model)
        rng = generator(bench.spec.seed, "directions", deviation.unit)
        zero, learnt = None, tuple[ParameterEstimate, ...]()
        if bench.spec.calibration_presses:
            known = identify_unit(sensor, _known(bench, simulated, rng), _robot(bench))
            learnt = tuple(
                compare_parameters(known, deviation, _inverse_friction(bench, deviation), bench.spec.tolerance)
            )
        elif bench.spec.zero:
            flat = _press(bench, deviation, unit_tilts(bench.spec, deviation.unit)[0])
            first = _read(bench, simulated, sensor, _turned(flat, float(rng.uniform(0, 360))))
            zero = find_depth_zero(first.estimates[:, 2], first.truth[:, 2], bench.spec.min_depth)
        tables = [
            _read(bench, simulated, sensor, _turned(press, float(rng.uniform(0, 360))), number).images
            for number, press in enumerate(item for item in presses for _ in range(bench.spec.azimuths))
        ]
    except PalpateError as error:
        return UnitTrial(deviation, np.empty((0, len(COLUMNS))), failure=str(error))
    return UnitTrial(deviation, np.concatenate(tables), zero, learnt)


def _refuse_none(presses: list[Press]) -> None:
    """Reject a unit without an inverted state."""
    for press in presses:
        if press.ended is EndReason.NO_BRANCH:
            raise PalpateError(
                press.message, "Press deeper, or let fewer units be inverted.", code="inverted-state-missing"
            )


def _known(
    bench: VirtualBench, simulated: SimulatedUnit, rng: np.random.Generator
) -> list[tuple[FloatArray, list[NDArray[np.uint8]], FloatArray]]:
    """Calibration presses of a unit, at two tilts and directions 144° apart, with robot errors.

    They are on a flat wall. The load cell is read once, at the deepest image of the first.
    """
    deviation = simulated.deviation
    level = replace(deviation, curvature=0.0)
    first, found = float(rng.uniform(0, 360)), []
    for number in range(bench.spec.calibration_presses):
        tilt, turn_deg = calibration_pose(number, bench.spec.max_tilt_deg)
        press = _turned(_press(bench, level, round(tilt, 3)), (first + turn_deg) % 360.0)
        poses = np.array([_robot_pose(press, deviation, depth) for depth in press.depth])
        poses[:, :2] += rng.normal(0.0, bench.spec.robot_tilt_deg, 2)
        poses[:, 2] += rng.normal(0.0, bench.spec.robot_depth)
        deep = press.depth >= bench.spec.min_depth - 1e-9
        cell = np.full(int(deep.sum()), np.nan)
        if not number:
            cell[-1] = _weigh(press)[-1]
        found.append((poses[deep], list(compress(simulated.render_press(press), deep)), cell))
    return found


def _weigh(press: Press) -> FloatArray:
    """Load-cell reading under the wall at each image of a press (n,), N along its normal."""
    return press.force @ wall_normal(np.radians(press.obstacle.radial), 0.0)  # as it was solved, not turned


def _robot(bench: VirtualBench) -> RobotUncertainty:
    return RobotUncertainty(bench.spec.robot_tilt_deg, bench.spec.robot_depth)


def _robot_pose(press: Press, deviation: Deviation, depth: float) -> tuple[float, float, float]:
    """rx, ry (degrees) and depth (mm) of an image on the robot's scale."""
    tilt, azimuth = press.obstacle.radial, np.radians(press.obstacle.turn_deg + deviation.seating_turn_deg)
    rx, ry = rotation_vector(tilt, azimuth) + np.array([deviation.seating_x_deg, deviation.seating_y_deg])
    # the robot starts where a dome of the design's thickness would be touched
    late = deviation.depth_zero - deviation.thickness / np.cos(np.radians(tilt))
    return float(rx), float(ry), float(depth + late)


def _read(bench: VirtualBench, simulated: SimulatedUnit, sensor: Sensor, press: Press, number: int = 0) -> UnitTrial:
    """Ground truth and readings of the evaluated images of a press."""
    rows, deviation = [], simulated.deviation
    slip = _inverse_friction(bench, deviation)
    for depth, force, image in zip(press.depth, _weigh(press), simulated.render_press(press), strict=True):
        reading = sensor.read(image)
        if depth >= bench.spec.min_depth - 1e-9:
            estimate, half = list(reading.pose), list(reading.half_width)
            if reading.fit is not None:
                pressing = reading.fit.force.normal_force
                estimate += [pressing.value, reading.fit.inverse_friction.value]
                half += [pressing.half_width, reading.fit.inverse_friction.half_width]
            nothing = [np.nan] * (len(MEASURANDS) - len(estimate))
            truth = (*_robot_pose(press, deviation, float(depth)), force, slip)
            rows.append(
                (number, len(reading.flags), reading.latency_ms, *truth, *estimate, *nothing, *half, *nothing)
            )
    return UnitTrial(deviation, np.array(rows).reshape(-1, len(COLUMNS)))


def _inverse_friction(bench: VirtualBench, deviation: Deviation) -> float:
    """1/µ of a unit's wall; NaN for a frictionless wall."""
    contact = deviation.friction or bench.spec.contact
    if isinstance(contact, str):
        return 0.0 if contact == "no-slip" else np.nan
    return 1.0 / contact


def _turned(press: Press, azimuth_deg: float) -> Press:
    """Return the press with its wall at another azimuth; `SimulatedUnit.press_edges` rotates its solution."""
    return replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": azimuth_deg}))


def _solve(bench: VirtualBench, deviation: Deviation, tilt_deg: float, branch: Branch) -> Press:
    built, wall = deviation.built(bench.design), _wall(bench, deviation, tilt_deg, branch)
    mesh = mesh_skin(built.skin, _mesh_spec(bench, deviation, branch))
    if branch is Branch.INVERTED:
        return solve_press(mesh, built.material, wall, branch=branch)
    return PRESS_SOLVERS.get(bench.spec.solver)().solve(mesh, built.material, wall)


def _mesh_spec(bench: VirtualBench, deviation: Deviation, branch: Branch) -> MeshSpec:
    if branch is Branch.INVERTED:
        own = bench.spec.cells or round(FINER * _own_cells(bench))
        return MeshSpec(cells=own, core=_INVERTED_CORE)
    whole = bool(deviation.lateral or deviation.twist_deg)
    cells = bench.spec.cells or (_own_cells(bench) if whole else round(FINER * _own_cells(bench)))
    return MeshSpec(cells=cells, whole=whole, filled=bench.design.material.has_gel)


def _own_cells(bench: VirtualBench) -> int:
    """Cells from pole to rim of the nominal skin's presses."""
    return mesh_skin(bench.design.skin, MeshSpec(filled=bench.design.material.has_gel)).spec.cells or 0


def _wall(bench: VirtualBench, deviation: Deviation, tilt_deg: float, branch: Branch) -> WallSpec:
    """Return the wall of a press, with a drawn lateral motion if robots drift.

    A skin slides while it inverts, so lateral motion has no effect then.
    """
    shares = generator(bench.spec.seed, "drift", deviation.unit, round(1e3 * tilt_deg)).uniform(-1.0, 1.0, 3)
    most = np.array([deviation.lateral, deviation.lateral, deviation.twist_deg]) / bench.spec.depth
    return WallSpec(
        tilt_deg=tilt_deg,
        depth=bench.spec.depth,
        depth_step=bench.spec.depth_step,
        contact=deviation.friction or bench.spec.contact,
        curvature=_curvature(bench, deviation, tilt_deg),
        **dict(
            zip(
                WallSpec.LATERAL_FIELDS if branch is Branch.FLAT else (),
                (most * shares).round(6).tolist(),
                strict=branch is Branch.FLAT,
            )
        ),
    )


def _curvature(bench: VirtualBench, deviation: Deviation, tilt_deg: float) -> float:
    """Curvature of the wall of a press, 1/m, of either sign."""
    share = generator(bench.spec.seed, "bend", deviation.unit, round(1e3 * tilt_deg)).uniform(-1.0, 1.0)
    return round(deviation.curvature * float(share), 4)


def _press_recipe(bench: VirtualBench, deviation: Deviation, tilt_deg: float, branch: Branch) -> Recipe:
    mesh, wall = _mesh_spec(bench, deviation, branch), _wall(bench, deviation, tilt_deg, branch)
    built = deviation.built(bench.design)
    if bench.spec.solver == "calculix" and branch is Branch.FLAT:
        return calculix_recipe(built, mesh, wall)
    solver = SolverSpec().model_dump(mode="json")
    return press_recipe(built.skin_spec, mesh, built.material, wall, solver, branch)


def unit_recipe(bench: VirtualBench, deviation: Deviation) -> Recipe:
    """Recipe of a unit's result."""
    spec = {
        "bench": bench.spec.model_dump(mode="json", exclude={"units", "inverted", "tolerance"}),
        "deviation": deviation.as_dict(),
        "markers_mm": bench.design.layout.positions.tolist(),
        "diameter": bench.design.layout.diameter,
        "camera": bench.design.camera_spec.model_dump(mode="json"),
        "model": bench.model_key or bench.model_sha256,
    }
    tilts, branch = unit_tilts(bench.spec, deviation.unit), _branch(bench, deviation)
    inputs = tuple(_press_recipe(bench, deviation, tilt, branch).key for tilt in tilts)
    return Recipe(kind="unit", spec=spec, inputs=inputs, version=stage_version("unit_trial"))
