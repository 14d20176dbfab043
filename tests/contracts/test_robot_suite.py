"""The simulated robot, without and with its errors, is a robot."""

import numpy as np
import pytest

from palpate.sensor import Placement, Robot
from palpate.simulation import SimulatedRobot, SimulatedRobotSpec
from palpate.testing import RobotSuite


class TestSimulatedRobot(RobotSuite):
    @pytest.fixture(params=[SimulatedRobotSpec(), SimulatedRobotSpec(position_sd_mm=1.0, rotation_sd_deg=1.0)])
    def robot(self, request: pytest.FixtureRequest) -> Robot:
        """It reports the placement that it was sent to; its errors are known to the simulation alone."""
        return SimulatedRobot(Placement(), request.param, np.random.default_rng(0), lambda _: np.zeros(3))
