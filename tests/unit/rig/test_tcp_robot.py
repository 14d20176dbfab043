"""A robot behind text lines, against a server that fails in every way: each fault ends the moves."""

import socket
import threading
from collections import Counter

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from errors import refused
from palpate.core import PalpateError
from palpate.design import DomeSpec, build_skin
from palpate.rig import PressFrame, open_robot
from palpate.rig.tcp_robot import TcpRobot
from palpate.sensor import Placement, rotation_from_vector

FAULTS = ("error", "drop", "silence", "garbage", "elsewhere", "askew", "infinite", "empty", "short")
START = Placement(rotation_from_vector(np.array([0.0, 180.0, 10.0])), np.array([400.0, -120.0, 300.0]))


class Server(threading.Thread):
    """Controller that is at a pose and obeys; it fails at its next request if `fault` is set, and stops if left."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.listening = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listening.getsockname()[1]}"
        self.pose, self.fault, self.moves = START, "", []
        self.start()

    def run(self) -> None:
        while True:
            connection, _ = self.listening.accept()
            with connection, connection.makefile("rb") as lines:
                for line in lines:
                    answer = self.answer(*line.decode().split())
                    if answer is None:
                        break
                    connection.sendall(answer)

    def answer(self, word: str, *numbers: str) -> bytes | None:
        fault = self.fault
        if word == "move":
            values = np.array(numbers, float)
            if fault in ("error", "drop", "garbage", "empty"):
                self.fault = ""
                return {"error": b"error joint limit\n", "drop": None, "garbage": b"\xff\n", "empty": b"\n"}[fault]
            if fault == "silence":
                self.fault = ""
                return b""
            values[:3] += 1.0 * (fault == "elsewhere")
            values[3:] += 2.0 * (fault == "askew")
            self.pose = Placement(Rotation.from_rotvec(values[3:], degrees=True).as_matrix(), values[:3])
            self.moves.append(self.pose)
            return b"done\n"
        turn = Rotation.from_matrix(self.pose.rotation).as_rotvec(degrees=True)
        told = [*self.pose.position, *turn]
        if fault in ("infinite", "short"):
            told = [np.inf, *told[1:]] if fault == "infinite" else told[:5]
        self.fault = ""
        return f"pose {' '.join(map(str, told))}\n".encode()


@pytest.fixture
def server() -> Server:
    return Server()


def test_a_thousand_moves_with_faults_stay_in_the_workspace_and_end_at_each_fault(server: Server) -> None:
    rng, frame = np.random.default_rng(5), PressFrame(START, build_skin(DomeSpec()))
    robot, met = TcpRobot(server.address, timeout_s=0.1), Counter[str]()
    for number in range(1000):
        tilt = rng.uniform(-10, 10, 2)
        target, before = frame.flange_at(np.array([*tilt, rng.uniform(-3, 4)])), len(server.moves)
        fault = FAULTS[number // 20 % len(FAULTS)] if number % 20 == 7 else ""
        server.fault = fault
        if not fault:
            robot.move(target)
            assert robot.flange_pose().position == pytest.approx(target.position, abs=1e-5)
            continue
        with refused("robot-lost", server.address) as caught:
            robot.move(target)
        met[fault] += 1
        assert str(caught.value).count("\n") <= 1
        for call in (robot.flange_pose, lambda: robot.move(START)):  # noqa: B023
            with refused("robot-lost"):
                call()
        assert len(server.moves) - before <= 1
        robot = TcpRobot(server.address, timeout_s=0.1)
    assert set(met) == set(FAULTS)
    places = np.array([pose.position for pose in server.moves])
    assert np.abs(places - START.position).max() < 12.0


def test_the_pose_has_the_units_of_the_page(server: Server) -> None:
    robot = open_robot(f"tcp:{server.address}")
    here = robot.flange_pose()
    assert here.position == pytest.approx([400.0, -120.0, 300.0])
    assert here.rotation == pytest.approx(START.rotation)
    robot.close()


@pytest.mark.parametrize("text", ["", "host", "host:", "host:port", ":80"])
def test_a_malformed_address_is_refused(text: str) -> None:
    with refused("robot-address"):
        TcpRobot(text)


def test_a_server_that_is_not_there_is_named() -> None:
    with pytest.raises(PalpateError) as caught:
        TcpRobot("127.0.0.1:9", timeout_s=0.5)
    assert caught.value.code == "robot-lost"
