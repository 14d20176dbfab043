"""A robot of Universal Robots, by ur-rtde, with a simulated controller that fails in every way."""

import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.rig import open_robot
from palpate.rig.ur_robot import UrRobot
from palpate.sensor import Placement, Robot, rotation_from_vector
from robot_moves import WORKSPACE, move_a_thousand_times
from ur_controller import START, UrController

needs("rtde_control")
FAST = "speed=400&acceleration=5000"
FAULTS = {
    "protective": "protective stop",
    "safeguard": "safeguard stop",
    "emergency": "emergency stop",
    "force": "80 N",
    "program": "",
    "silence": "no data",
    "drop": "",
}


@pytest.fixture
def controller() -> Iterator[UrController]:
    made = UrController()
    yield made
    made.close()


def opened(controller: UrController, query: str = FAST) -> UrRobot:
    return UrRobot(f"{controller.host}?{query}")


def moved(controller: UrController, number: int) -> np.ndarray:
    return np.ptp([place[:3] for place in controller.places[number:]], axis=0)


def test_the_tool_centre_point_is_set_to_the_flange_and_units_are_converted(controller: UrController) -> None:
    robot = open_robot(f"ur:{controller.host}?{FAST}")
    here = robot.flange_pose()
    assert controller.tool == pytest.approx(np.zeros(6))
    assert here.position == pytest.approx([400.0, -120.0, 300.0])
    assert here.rotation == pytest.approx(np.diag([-1.0, 1.0, -1.0]), abs=0.05)
    robot.move(here.moved(np.array([0.0, 0.0, -2.0])))
    assert controller.pose[:3] == pytest.approx([0.4, -0.12, 0.298], abs=1e-6)
    robot.close()
    assert not controller.running


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_ends_in_a_stop_with_one_sentence(controller: UrController, fault: str) -> None:
    robot = opened(controller, "speed=10&acceleration=5000&stall_s=0.2")
    goal = robot.flange_pose().moved(np.array([0.0, 0.0, 8.0]))
    controller.fault = fault
    with refused("robot-lost", FAULTS[fault]) as caught:
        robot.move(goal)
    assert str(caught.value).count("\n") <= 1
    time.sleep(0.5)
    assert not controller.running or controller.safety != 1
    assert 4.0 < 1e3 * (controller.pose[2] - START[2]) < 7.5
    commands = len(controller.commands)
    for call in (robot.flange_pose, lambda: robot.move(Placement())):
        with refused("robot-lost"):
            call()
    assert len(controller.commands) == commands
    robot.close()


def test_no_move_leaves_the_workspace(controller: UrController) -> None:
    robot = opened(controller, f"{FAST}&workspace=10")
    with refused("robot-lost", "11 mm", "10 mm"):
        robot.move(robot.flange_pose().moved(np.array([0.0, 11.0, 0.0])))
    assert not controller.commands
    robot.close()


def test_limits_hold_between_moves_and_at_the_connection(controller: UrController) -> None:
    robot = opened(controller, f"{FAST}&tilt=20")
    here = robot.flange_pose()
    with refused("robot-lost", "30 degrees", "20"):
        robot.move(Placement(here.rotation @ rotation_from_vector(np.array([30.0, 0.0, 0.0])), here.position))
    assert not controller.commands
    robot.close()
    robot = opened(controller, FAST)
    controller.force = np.array([0.0, 0.0, 80.0, 0.0, 0.0, 0.0])
    time.sleep(0.1)  # until the controller has sent it
    with refused("robot-lost", "80 N"):
        robot.flange_pose()
    robot.close()
    with refused("robot-lost", "80 N"):
        opened(controller, FAST)
    assert not controller.commands


def test_a_killed_process_stops_the_robot_by_the_watchdog_of_the_controller(controller: UrController) -> None:
    robot = opened(controller, "speed=10&acceleration=5000&stall_s=0.1")
    threading.Timer(0.3, robot._process.kill).start()
    with refused("robot-lost"):
        robot.move(robot.flange_pose().moved(np.array([0.0, 0.0, 10.0])))
    time.sleep(0.4)
    assert not controller.running
    assert 1.0 < 1e3 * (controller.pose[2] - START[2]) < 6.0


@pytest.mark.parametrize(
    ("text", "code", "value"),
    [
        ("", "robot-address", "''"),
        ("?force=30", "robot-address", "force=30"),
        ("127.0.0.1?force=30&force=500", "robot-address", "force=500"),
        ("127.0.0.1?speed=0.5", "robot-setting", "0.5"),
        ("127.0.0.1?force=0", "robot-setting", "0"),
        ("127.0.0.1?power=3", "robot-setting", "power"),
        ("127.0.0.1?speed=fast", "robot-setting", "fast"),
        ("127.0.0.1", "robot-lost", "127.0.0.1"),
    ],
)
def test_a_wrong_address_is_refused(text: str, code: str, value: str) -> None:
    with refused(code, value):
        open_robot(f"ur:{text}")


@pytest.mark.slow
def test_a_thousand_moves_with_faults_stay_in_the_workspace(controller: UrController) -> None:
    query = "speed=200&acceleration=9000&workspace=20&stall_s=0.3"

    def inject(_: Robot, fault: str) -> None:
        controller.fault = fault

    def reopen(robot: Robot) -> UrRobot:
        robot.close()
        time.sleep(0.3)
        assert not controller.running or controller.safety != 1
        controller.fault, controller.safety, controller.silent, controller.force = "", 1, False, np.zeros(6)
        controller.drop()
        return opened(controller, query)

    met = move_a_thousand_times(opened(controller, query), FAULTS, inject, reopen, apart_mm=0.11)
    assert min(met[fault] for fault in (*FAULTS, WORKSPACE)) >= 5
    assert 1e3 * np.linalg.norm(np.array(controller.places)[:, :3] - START[:3], axis=1).max() < 20.0
