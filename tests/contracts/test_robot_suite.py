"""The manual robot and the simulated one, without and with its errors, are robots."""

import io
import sys
from collections.abc import Iterator

import numpy as np
import pytest

from needs import needs
from palpate.rig import ManualRobot, open_robot
from palpate.sensor import Placement, Robot
from palpate.simulation import SimulatedRobot, SimulatedRobotSpec
from palpate.testing import RobotSuite
from ros_bridge import RosBridge
from ur_controller import UrController


class TestManualRobot(RobotSuite):
    @pytest.fixture
    def robot(self, monkeypatch: pytest.MonkeyPatch) -> Robot:
        """The user confirms each pose."""
        monkeypatch.setattr(sys, "stdin", io.StringIO("\n" * 10))
        return ManualRobot()


class TestUrRobot(RobotSuite):
    @pytest.fixture
    def robot(self) -> Iterator[Robot]:
        """It is moved by ur-rtde and a simulated controller."""
        needs("rtde_control")
        controller = UrController()
        robot = open_robot(f"ur:{controller.host}?speed=200&acceleration=5000")
        yield robot
        robot.close()
        controller.close()


class TestRosRobot(RobotSuite):
    @pytest.fixture
    def robot(self) -> Iterator[Robot]:
        """It is moved by MoveIt's action and a simulated rosbridge_server."""
        needs("websockets")
        bridge = RosBridge()
        robot = open_robot(f"ros2:{bridge.host}?wrench=/ft/wrench&speed=0.4")
        yield robot
        robot.close()
        bridge.close()


class TestSimulatedRobot(RobotSuite):
    @pytest.fixture(params=[SimulatedRobotSpec(), SimulatedRobotSpec(position_sd_mm=1.0, rotation_sd_deg=1.0)])
    def robot(self, request: pytest.FixtureRequest) -> Robot:
        """It reports the placement that it was sent to; its errors are known to the simulation alone."""
        return SimulatedRobot(Placement(), request.param, np.random.default_rng(0), lambda _: np.zeros(3))
