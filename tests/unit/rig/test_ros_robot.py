"""A robot of ROS 2, by rosbridge and MoveIt's action, with a simulated server that fails in every way."""

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.rig import open_robot
from palpate.rig.ros_robot import RosRobot
from palpate.sensor import Placement, Robot, rotation_from_vector
from robot_moves import WORKSPACE, move_a_thousand_times
from ros_bridge import DOWN, START, RosBridge

needs("websockets")
FORCES = "wrench=/ft/wrench&force=50&stall_s=0.2"
FAULTS = {
    "planning": "-1",
    "control": "-4",
    "aborted": "status 6",
    "drop": "does not answer",
    "silence": "0.4 s",
    "short": "mm",
    "force": "80 N",
    "no forces": "/ft/wrench",
}


@pytest.fixture
def bridge() -> Iterator[RosBridge]:
    made = RosBridge()
    yield made
    made.close()


def opened(bridge: RosBridge, query: str = FORCES, timeout_s: float = 5.0) -> RosRobot:
    return RosRobot(f"{bridge.host}?{query}", timeout_s=timeout_s)


def test_units_are_converted_and_the_goal_has_position_and_orientation(bridge: RosBridge) -> None:
    robot = open_robot(f"ros2:{bridge.host}?{FORCES}&speed=0.2")
    here = robot.flange_pose()
    assert here.position == pytest.approx([400.0, -120.0, 300.0])
    assert here.rotation == pytest.approx(np.diag([-1.0, 1.0, -1.0]), abs=1e-9)
    turn = rotation_from_vector(np.array([3.0, -2.0, 1.0]))
    goal = Placement(here.rotation @ turn, here.position + np.array([1.0, 2.0, -3.0]))
    robot.move(goal)
    assert bridge.position == pytest.approx([0.401, -0.118, 0.297], abs=1e-9)
    assert bridge.turn.as_matrix() == pytest.approx(goal.rotation, abs=1e-9)
    request = bridge.goals[-1]["request"]
    assert [request[f"max_{name}_scaling_factor"] for name in ("velocity", "acceleration")] == [0.2, 0.2]
    assert (request["pipeline_id"], request["planner_id"]) == ("pilz_industrial_motion_planner", "LIN")
    robot.close()
    assert "cancel_action_goal" not in bridge.heard


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_ends_with_one_sentence_and_nothing_moves_again(bridge: RosBridge, fault: str) -> None:
    robot = opened(bridge, f"{FORCES}&speed=0.006", timeout_s=0.4 if fault == "silence" else 5.0)
    bridge.fault = fault if fault == "planning" else ""
    goal = robot.flange_pose().moved(np.array([0.0, 0.0, 6.0]))
    threading.Timer(0.1, setattr, (bridge, "fault", fault)).start()
    with refused("robot-lost", FAULTS[fault]) as caught:
        robot.move(goal)
    assert str(caught.value).count("\n") <= 1
    time.sleep(0.1)
    count, place = len(bridge.goals), bridge.position
    assert place[2] < START[2] + 0.0055
    for call in (robot.flange_pose, lambda: robot.move(Placement())):
        with refused("robot-lost"):
            call()
    assert len(bridge.goals) == count
    assert (bridge.position == place).all()
    if fault in ("force", "no forces", "silence"):
        assert bridge.stopped


def test_an_interrupted_move_is_stopped(bridge: RosBridge) -> None:
    robot = opened(bridge, "speed=0.01")
    threading.Timer(0.05, robot.close).start()
    with refused("robot-lost"):
        robot.move(robot.flange_pose().moved(np.array([0.0, 0.0, 6.0])))
    time.sleep(0.1)
    assert bridge.stopped
    assert bridge.position[2] < START[2] + 0.0055


def test_a_terminated_process_stops_the_robot(bridge: RosBridge, tmp_path: Path) -> None:
    images = Path(__file__).parents[3] / "examples" / "data" / "recording"
    take = f"recording take --robot ros2:{bridge.host}?speed=0.0005 --tilts 1 --azimuths 1 --depths 1 --markers 37"
    command = ["-m", "palpate", *take.split(), "--source", str(images), "--out", str(tmp_path / "new")]
    process = subprocess.Popen([sys.executable, *command], stderr=subprocess.PIPE, text=True)
    while not bridge.goals and process.poll() is None:
        time.sleep(0.05)
    process.terminate()
    said = process.communicate(timeout=60)[1]
    assert (process.returncode, said.count("Interrupted")) == (130, 1), said
    assert bridge.stopped


def test_no_move_leaves_the_workspace(bridge: RosBridge) -> None:
    robot = opened(bridge, "workspace=10&tilt=20")
    with refused("robot-lost", "11 mm", "10 mm"):
        robot.move(robot.flange_pose().moved(np.array([0.0, 11.0, 0.0])))
    robot = opened(bridge, "workspace=10&tilt=20")
    here = robot.flange_pose()
    with refused("robot-lost", "30 degrees", "20"):
        robot.move(Placement(here.rotation @ rotation_from_vector(np.array([30.0, 0.0, 0.0])), here.position))
    assert not bridge.goals


def test_forces_are_checked_at_the_connection_and_when_the_pose_is_read(bridge: RosBridge) -> None:
    robot = opened(bridge)
    bridge.force = np.array([0.0, 0.0, -57.0])  # a change of 49 N
    time.sleep(0.05)
    robot.flange_pose()
    bridge.force = np.array([0.0, 0.0, 44.0])  # of 52 N
    time.sleep(0.05)
    with refused("robot-lost", "52 N", "50 N"):
        robot.flange_pose()
    bridge.force = np.array([0.0, 0.0, 51.0])
    with refused("robot-lost", "51 N", "50 N"):
        opened(bridge)


def test_the_first_force_may_come_late_and_each_goal_has_its_own_name(bridge: RosBridge) -> None:
    bridge.late_s = 0.4
    first = opened(bridge)  # no force for more than the 0.2 s of `FORCES`
    first.move(first.flange_pose().moved(np.array([0.0, 0.0, 0.5])))
    first.close()
    bridge.late_s = 0.0
    second = opened(bridge)
    second.move(second.flange_pose().moved(np.array([0.0, 0.0, 0.5])))
    assert len(bridge.names) == len(set(bridge.names)) == 2


def test_forces_during_a_pause_are_received_and_checked(bridge: RosBridge) -> None:
    robot = opened(bridge)
    time.sleep(0.3)  # sixty messages, more than the sixteen of the library's queue
    assert robot._socket.recv_messages.frames.qsize() > 30
    bridge.force = np.array([0.0, 0.0, 80.0])
    time.sleep(0.05)
    bridge.force = np.array([0.0, 0.0, -8.0])
    with refused("robot-lost", "50 N"):
        robot.flange_pose()


@pytest.mark.parametrize("fault", ["no pose", "null", "large", "infinite", "no service", "text"])
def test_a_pose_that_cannot_be_read_is_refused(bridge: RosBridge, fault: str) -> None:
    robot = opened(bridge)
    bridge.pose_fault = fault
    with refused("robot-lost", "/compute_fk" if fault == "no service" else ""):
        robot.flange_pose()


@pytest.mark.parametrize(("query", "value"), [("link=flange", "-18"), ("base=world", "-18")])
def test_an_unknown_link_or_frame_is_refused_at_the_connection(bridge: RosBridge, query: str, value: str) -> None:
    with refused("robot-lost", value):
        opened(bridge, query)


def test_an_unknown_group_moves_nothing(bridge: RosBridge) -> None:
    robot = opened(bridge, "group=arm")
    with refused("robot-lost", "-15"):
        robot.move(robot.flange_pose().moved(np.array([0.0, 0.0, 1.0])))
    assert not bridge.places


@pytest.mark.parametrize(
    ("text", "code", "value"),
    [
        ("", "robot-address", "''"),
        ("?force=30", "robot-address", "force=30"),
        ("127.0.0.1:1?force=30&force=500", "robot-address", "force=500"),
        ("127.0.0.1:1?speed=1.5", "robot-setting", "1.5"),
        ("127.0.0.1:1?power=3", "robot-setting", "power"),
        ("127.0.0.1:1", "robot-lost", "127.0.0.1:1"),
        ("[::1]:1", "robot-lost", "[::1]:1"),
        ("127.0.0.1:ninety", "robot-address", "ninety"),
        ("127.0.0.1:99999", "robot-address", "99999"),
        ("::1", "robot-address", "::1"),
        ("ws://127.0.0.1:1", "robot-address", "ws://127.0.0.1:1"),
        ("name:word@127.0.0.1:1", "robot-address", "word"),
    ],
)
def test_a_wrong_address_is_refused(text: str, code: str, value: str) -> None:
    with refused(code, value):
        open_robot(f"ros2:{text}")


@pytest.mark.slow(40)
def test_a_thousand_moves_with_faults_stay_in_the_workspace(bridge: RosBridge) -> None:
    query = f"{FORCES}&workspace=20&speed=0.4"

    def inject(robot: Robot, fault: str) -> None:
        bridge.fault = fault
        robot._timeout_s = 0.4 if fault == "silence" else 5.0  # type: ignore[attr-defined]

    def reopen(_: Robot) -> RosRobot:
        time.sleep(0.05)
        bridge.fault, bridge.position, bridge.turn = "", START.copy(), DOWN
        return opened(bridge, query)

    met = move_a_thousand_times(opened(bridge, query), FAULTS, inject, reopen, apart_mm=0.01)
    assert min(met[fault] for fault in (*FAULTS, WORKSPACE)) >= 5
    assert np.linalg.norm(np.array(bridge.places) - START, axis=1).max() < 0.02
