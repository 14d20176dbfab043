"""A drill is squared to walls by units built askew, on a robot that is not where it says; and what ends it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from errors import refused
from made_up_readings import make_fit
from palpate.calibration import CONTACT_STATE, ToleranceSpec
from palpate.core import PalpateError
from palpate.core.state import State
from palpate.design import Design, build_skin, place_markers, wall_normal
from palpate.fea import Press
from palpate.fea.press import IncrementFields
from palpate.sensor import (
    Aligner,
    AlignmentOutcome,
    AlignSpec,
    Placement,
    Robot,
    Tool,
    find_tool_offset,
    tilt_from_normal,
)
from palpate.sensor.alignment import Touch
from palpate.sensor.placement import rotation_from_vector
from palpate.simulation import (
    AlignmentScenario,
    SimulatedRobotSpec,
    SolverBackend,
    TwinBackend,
    VirtualUnit,
    WorkpieceSpec,
    write_alignments,
)
from palpate.surrogate import Twin, read_twin, write_twin
from small_chain import DOME, MARKERS, MATERIAL, write_small_twin

SPEC = AlignSpec(depth=3.5, min_depth=1.5, force_n=0.4, tolerance_deg=0.6)
WALLS = ToleranceSpec(friction_min=0.5, friction_max=5.0, lateral=0.2)
POINTS = place_markers(build_skin(DOME), MARKERS).positions
NEAR = Placement(position=np.array([0.0, 0.0, 120.0]))


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> Twin:
    return read_twin(write_small_twin(tmp_path_factory.mktemp("twin") / "twin.h5"))


def play(twin: Twin, **changes: Any) -> AlignmentScenario:
    return AlignmentScenario(
        twin,
        Design(DOME, MARKERS, material=MATERIAL),
        align=SPEC,
        **{"calibration_presses": 0, "max_tilt_deg": 4.0, "tolerance": WALLS} | changes,
    )


@pytest.fixture(scope="module")
def unit(twin: Twin) -> VirtualUnit:
    return VirtualUnit(play(twin), 1)


def test_a_drill_stands_square_after_some_touches_and_the_force_is_kept(unit: VirtualUnit, tmp_path: Path) -> None:
    walls = [unit.square(number) for number in range(3)]
    for wall in walls:
        assert wall.alignment.square, wall.alignment.outcome
        assert wall.final_deg < 0.6
        assert len(wall.alignment.touches) <= 4
        assert 0.02 < wall.max_force_n < SPEC.force_n
    assert np.median([len(wall.alignment.touches) for wall in walls]) <= 2
    first = walls[0].alignment
    assert first.angles_deg[0] == pytest.approx(walls[0].tilt_deg, abs=0.6)
    write_alignments(tmp_path / "new", walls, {"seed": 0})
    rows = (tmp_path / "new" / "touches.csv").read_text().splitlines()
    assert len(rows) == 1 + sum(len(wall.alignment.touches) for wall in walls)
    assert '"made_by"' in (tmp_path / "new" / "alignment.json").read_text()


def test_a_compliant_wall_is_in_equilibrium_with_the_skin(unit: VirtualUnit) -> None:
    """Springs in series: the force is that of a rigid wall at the depth that the skin is left with."""
    tilt = np.array([2.0, 1.0])
    stiff, robot = unit._before(tilt, 1.0, np.random.default_rng(3))
    way = robot.true_pose.rotation[:, 2]
    pressed = robot.true_pose.moved((3.0 - stiff.depth_at(robot.true_pose)) * way)
    soft, _ = unit._before(tilt, 1.0, np.random.default_rng(3), WorkpieceSpec(wall_compliance=5.0))
    force = -soft.push(pressed) @ soft._wall.normal
    assert 0.3 * force < 0.8 * -stiff.push(pressed) @ stiff._wall.normal
    left = pressed.moved(-5.0 * force * (soft._wall.normal @ way) ** -1 * way)
    assert -stiff.push(left) @ stiff._wall.normal == pytest.approx(force, rel=1e-3)
    assert soft.depth_at(pressed) == pytest.approx(stiff.depth_at(left), abs=1e-3)
    turned, _ = unit._before(tilt, 1.0, np.random.default_rng(3), WorkpieceSpec(wall_tilt_compliance=2.0), 0.7)
    loaded = turned._wall.under(1.5)
    assert np.degrees(np.arccos(loaded.normal @ turned._wall.normal)) == pytest.approx(3.0)
    assert turned._wall.axis @ turned._wall.normal == pytest.approx(0.0, abs=1e-12)
    assert stiff.depth_at(pressed.moved(-10.0 * way)) == soft.depth_at(pressed.moved(-10.0 * way)) < 0


def test_a_workpiece_that_tilts_is_aligned_under_the_force_of_the_touch(twin: Twin, unit: VirtualUnit) -> None:
    """The skin reads the loaded wall: the free one is off by its rotation in the touch, the clamped one by more."""
    rigid = unit.square(1)
    given = VirtualUnit(play(twin, workpiece=WorkpieceSpec(wall_tilt_compliance=4.0, clamping_force=0.9)), 1).square(
        1
    )
    assert rigid.clamped_deg == rigid.final_deg < 0.2
    assert given.alignment.square
    touch = given.alignment.touches[-1].fit.force.normal_force.value
    assert given.final_deg == pytest.approx(4.0 * touch, abs=rigid.final_deg + 0.05)
    assert given.clamped_deg == pytest.approx(4.0 * (0.9 - touch), abs=rigid.final_deg + 0.05)


def test_a_support_that_turns_far_is_refused() -> None:
    assert WorkpieceSpec(wall_tilt_compliance=1.0, clamping_force=30.0).clamping_force == 30.0
    with refused("workpiece-turned", "31"):
        WorkpieceSpec(wall_tilt_compliance=1.0, clamping_force=31.0)


def test_the_tools_offset_is_told_by_six_touches(unit: VirtualUnit) -> None:
    assert unit.offset_touches == 6
    assert unit.offset_error_deg < 0.2
    askew = unit.tool.flange_from_sensor.rotation[:, 2]
    assert np.degrees(np.arccos(askew[2])) > 2 * unit.offset_error_deg


def test_the_force_limit_makes_touches_shallower_or_ends(twin: Twin, unit: VirtualUnit) -> None:
    cell, robot = unit._before(np.array([2.0, 1.0]), 1.0, np.random.default_rng(3))

    def run(**changes: Any) -> tuple[Any, float]:
        cell.max_force_n = 0.0
        spec = SPEC.model_copy(update=changes)
        said = Aligner(robot, unit._sensor, cell.next_image, unit.tool, spec).align()
        return said, cell.max_force_n

    free, force = run(max_touches=1)
    limited, less = run(force_n=0.6 * force, max_touches=1)
    assert less < 0.6 * force
    assert limited.touches[0].depth < free.touches[0].depth - 0.3
    assert all(touch.fit.force.normal_force.value <= touch.force_upper_n for touch in free.touches)
    shallow, least = run(force_n=0.6 * force, min_depth=3.3)
    assert shallow.outcome is AlignmentOutcome.TOO_SHALLOW
    assert least < 0.6 * force
    with refused("force-limit-passed", "1.25"):
        run(force_n=0.001)


def go_dark(unit: VirtualUnit, dark: Callable[[int, float], bool]) -> tuple[Any, float, list[float]]:
    """An alignment whose images are gone where `dark` says so, of their number and true depth; force and places."""
    cell, robot = unit._before(np.array([2.0, -1.0]), 1.0, np.random.default_rng(4))
    count, places = 0, []

    def next_image() -> Any:
        nonlocal count
        count += 1
        image = cell.next_image()
        if dark(count, cell.depth_at(robot.true_pose)):
            places.append(float(robot.flange_pose().position[2]))
            return PalpateError("No image.", "Look again.", code="image-damaged")
        return image

    said = Aligner(robot, unit._sensor, next_image, unit.tool, SPEC).align()
    assert cell.depth_at(robot.true_pose) < 0, "it leaves the wall"
    return said, cell.max_force_n, places


def test_without_images_nothing_is_pressed(unit: VirtualUnit) -> None:
    said, force, places = go_dark(unit, lambda count, depth: True)
    assert said.outcome is AlignmentOutcome.UNREADABLE
    assert said.images == len(places) == SPEC.max_image_retries
    assert len(set(places)) == 1, "it never goes on blindly"
    assert force == 0.0
    assert np.isnan(said.residual_deg)


def test_a_touch_that_is_dark_from_its_beginning_is_left(unit: VirtualUnit) -> None:
    said, force, places = go_dark(unit, lambda count, depth: depth > 0.0)
    assert said.outcome is AlignmentOutcome.UNREADABLE
    assert not said.square
    assert len(set(places)) == 1
    assert force < 0.1


def test_a_depth_that_cannot_be_read_leaves_the_one_before_it(unit: VirtualUnit) -> None:
    said, _, places = go_dark(unit, lambda count, depth: depth > 2.6)
    assert len(places) >= SPEC.max_image_retries
    assert said.square
    assert all(SPEC.min_depth <= touch.depth < 2.7 for touch in said.touches)


def test_a_wall_out_of_reach_is_said(unit: VirtualUnit) -> None:
    cell, robot = unit._before(np.zeros(2), 1.0, np.random.default_rng(5))
    short = SPEC.model_copy(update={"search": 1.0})
    assert Aligner(robot, unit._sensor, cell.next_image, unit.tool, short).align().outcome is AlignmentOutcome.NO_WALL


def test_an_angle_that_stays_uncertain_is_not_called_square(unit: VirtualUnit) -> None:
    cell, robot = unit._before(np.array([1.0, 0.0]), 1.0, np.random.default_rng(6))
    strict = SPEC.model_copy(update={"tolerance_deg": 0.01, "max_touches": 2})
    said = Aligner(robot, unit._sensor, cell.next_image, unit.tool, strict).align()
    assert said.outcome is AlignmentOutcome.TOO_MANY
    assert len(said.touches) == 2
    assert said.residual_deg + said.residual_half_width_deg > 0.01


def made_touches(truth: Placement, normal: np.ndarray, turns: list[tuple[float, float]]) -> list[Touch]:
    touches = []
    for about, lean in turns:
        flange = rotation_from_vector(np.array([0, 0, about])) @ rotation_from_vector(np.array([lean, 0, 0]))
        tilt = tilt_from_normal((flange @ truth.rotation).T @ normal)
        touches.append(Touch(Placement(flange), make_fit([*tilt, 4.0], 0.01**2 * np.eye(3)), False))
    return touches


def test_an_offset_is_told_exactly_from_exact_touches_and_its_turn_only_by_leaning() -> None:
    truth = Placement(rotation_from_vector(np.array([0.8, -0.5, 1.2])), NEAR.position)
    normal = wall_normal(*np.radians([2.0, 1.0]))
    turns = [(60.0 * k, 3.0 * (-1) ** k) for k in range(6)]
    found = find_tool_offset(Tool(NEAR), made_touches(truth, normal, turns), 0.001)
    assert found.flange_from_sensor.rotation == pytest.approx(truth.rotation, abs=2e-5)
    upright = find_tool_offset(Tool(NEAR), made_touches(truth, normal, [(k, 0.0) for k, _ in turns]), 0.001)
    assert upright.drill_in_sensor == pytest.approx(truth.rotation.T @ upright.drill, abs=1e-3)
    assert np.sqrt(np.diag(upright.covariance))[2] > 2.9
    assert np.sqrt(np.diag(found.covariance))[2] < 0.3


def test_touches_of_two_walls_or_too_few_tell_no_offset() -> None:
    turns = [(60.0 * k, 3.0 * (-1) ** k) for k in range(6)]
    mixed = made_touches(NEAR, wall_normal(0.0, 0.0), turns[:3]) + made_touches(
        NEAR, wall_normal(0.1, 0.1), turns[3:]
    )
    with refused("tool-touches-misfit"):
        find_tool_offset(Tool(NEAR), mixed, 0.01)
    with refused("tool-few-touches", "2"):
        find_tool_offset(Tool(NEAR), mixed[:2], 0.01)


def test_a_simulated_robot_errs_as_it_is_said_to(unit: VirtualUnit) -> None:
    spec = SimulatedRobotSpec(backlash_mm=0.0, backlash_deg=0.0)
    from palpate.simulation import SimulatedRobot

    def free(_: Placement) -> np.ndarray:
        return np.zeros(3)

    robot: Robot = SimulatedRobot(Placement(), spec, np.random.default_rng(0), free)
    assert isinstance(robot, SimulatedRobot)
    places, turns = [], []
    for number in range(400):
        goal = Placement(
            rotation_from_vector(np.array([0.0, 0.1 * (number % 2), 0.0])), np.array([0.0, 0.0, float(number % 2)])
        )
        robot.move(goal)
        assert robot.flange_pose() is goal
        places.append(robot.true_pose.position - goal.position)
        turns.append(tilt_from_normal((goal.rotation.T @ robot.true_pose.rotation)[:, 2]))
    assert np.std(places) == pytest.approx(0.1, rel=0.1)
    assert np.std(turns) == pytest.approx(0.05, rel=0.1)

    def spring(place: Placement) -> np.ndarray:
        return np.array([0.0, 0.0, -2.0 * max(place.position[2], 0.0)])

    soft = spec.model_copy(update={"compliance": 0.2, "position_sd_mm": 0.0})
    pushed = SimulatedRobot(Placement(), soft, np.random.default_rng(0), spring)
    pushed.move(Placement(position=np.array([0.0, 0.0, 1.0])))
    assert pushed.true_pose.position[2] == pytest.approx(1.0 / 1.4, abs=1e-6)


def test_twin_and_solver_show_the_same_markers_of_one_unit(twin: Twin, unit: VirtualUnit) -> None:
    """Two ways to the same markers: by the twin, and by a press solved anew, of a tilt between those of the twin."""
    simulated = unit._backend.unit
    by_twin, solved = TwinBackend(simulated, twin), SolverBackend(simulated, 4.0, cells=6)
    contact = State.zeros(CONTACT_STATE).replace(rx_deg=2.5, ry_deg=-1.5, depth_mm=3.1, inverse_friction=1.0)
    one, other = (backend.edges(contact) for backend in (by_twin, solved))
    assert np.linalg.norm(one - other, axis=2).max() < 0.05 * np.linalg.norm(one - simulated.edges, axis=2).max()
    forces = [float(np.linalg.norm(backend.force(contact))) for backend in (by_twin, solved)]
    assert forces[0] == pytest.approx(forces[1], rel=0.05)


def test_the_command_prints_touches_and_writes_them(
    twin: Twin, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from palpate.cli import main

    write_twin(tmp_path / "twin.h5", twin)
    words = [
        "simulation",
        "align",
        "--model",
        str(tmp_path / "twin.h5"),
        "--markers",
        "37",
        "--walls",
        "1",
        "--calibration-presses",
        "2",
    ]
    words += ["--depth", "3.5", "--min-depth", "1.5", "--tolerance", "0.9", "-o", str(tmp_path / "out")]
    with pytest.raises(SystemExit) as left:
        main(words)
    assert left.value.code in (0, None)
    assert "Wall 1: " in capsys.readouterr().out
    assert (tmp_path / "out" / "touches.csv").read_text().startswith("wall,touch,rx_deg")


def test_images_of_a_press_are_cut_out_whole(twin: Twin, unit: VirtualUnit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Markers between increments are read from a press of the four about them, whose every field has four rows."""
    solved, seen = SolverBackend(unit._backend.unit, 1.0, cells=4), []
    positions = Press.positions

    def remember(press: Press, points: np.ndarray) -> np.ndarray:
        seen.append(press)
        return positions(press, points)

    monkeypatch.setattr(Press, "positions", remember)
    solved.edges(State.zeros(CONTACT_STATE).replace(rx_deg=1.0, depth_mm=0.7))
    assert {len(getattr(seen[0], name)) for name in IncrementFields.__annotations__} == {4}
    whole = next(iter(solved._solved.values()))
    both = whole.cut(1, 3)
    assert np.array_equal(both.depth, whole.depth[1:3])
    assert np.array_equal(both.positions(POINTS), positions(whole, POINTS)[1:3])
