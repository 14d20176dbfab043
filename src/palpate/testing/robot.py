"""Contract suite of robots that carry a sensor."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.sensor import Placement, Robot, rotation_from_vector


class RobotSuite:
    """Inherit and give the fixture `robot`, which is moved by 2 mm and rotated by 1°."""

    TOLERANCE_MM = 0.05
    TOLERANCE_DEG = 0.05
    """Limit of the difference between the placement that is asked for and the one that the robot reports."""

    @pytest.fixture
    def robot(self) -> Robot:
        """A robot that is free to move by 2 mm."""
        raise NotImplementedError("Give the fixture `robot`.")

    def _check(self, robot: Robot, wanted: Placement) -> None:
        there = robot.flange_pose()
        assert np.linalg.norm(there.position - wanted.position) <= self.TOLERANCE_MM
        turn = (np.trace(there.rotation.T @ wanted.rotation) - 1.0) / 2.0
        assert np.degrees(np.arccos(np.clip(turn, -1.0, 1.0))) <= self.TOLERANCE_DEG

    def test_its_placement_is_a_right_handed_frame(self, robot: Robot) -> None:
        there = robot.flange_pose()
        assert there.rotation.T @ there.rotation == pytest.approx(np.eye(3), abs=1e-6)
        assert np.linalg.det(there.rotation) > 0

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_it_travels_along_an_axis_and_says_so(self, robot: Robot, axis: int) -> None:
        start = robot.flange_pose()
        for sign in (1.0, -1.0):
            wanted = start.moved(2.0 * sign * np.eye(3)[axis])
            robot.move(wanted)
            self._check(robot, wanted)

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_it_turns_about_an_axis_in_place_and_says_so(self, robot: Robot, axis: int) -> None:
        start = robot.flange_pose()
        wanted = Placement(start.rotation @ rotation_from_vector(np.eye(3)[axis]), start.position)
        robot.move(wanted)
        self._check(robot, wanted)

    def test_it_comes_back(self, robot: Robot) -> None:
        start = robot.flange_pose()
        robot.move(start.moved(np.array([1.0, -1.0, 0.5])))
        robot.move(start)
        self._check(robot, start)

    def test_a_move_to_where_it_is_changes_nothing(self, robot: Robot) -> None:
        start = robot.flange_pose()
        robot.move(start)
        self._check(robot, start)
