"""Moves of a robot behind a simulated controller, one in twenty with a fault."""

import itertools
from collections import Counter
from collections.abc import Callable, Iterable

import numpy as np
import pytest

from errors import refused
from palpate.design import DomeSpec, build_skin
from palpate.rig import PressFrame
from palpate.sensor import Robot

WORKSPACE = "workspace"
"""Fault of a goal 60 mm from the start."""


def move_a_thousand_times(
    robot: Robot,
    faults: Iterable[str],
    inject: Callable[[Robot, str], None],
    reopen: Callable[[Robot], Robot],
    apart_mm: float,
) -> Counter[str]:
    """Move within 10 mm of the start; each fault must stop the robot. Returns how often each fault occurred."""
    rng, met, each = np.random.default_rng(5), Counter[str](), itertools.cycle((*faults, WORKSPACE))
    frame = PressFrame(robot.flange_pose(), build_skin(DomeSpec()))
    for number in range(1000):
        goal = frame.flange_at(np.array([*rng.uniform(-8, 8, 2), rng.uniform(-3, 4)]))
        if number % 20 != 7:
            robot.move(goal)
            assert robot.flange_pose().position == pytest.approx(goal.position, abs=apart_mm)
            continue
        fault, here = next(each), robot.flange_pose()
        inject(robot, fault)
        with refused("robot-lost"):
            robot.move(here.moved(np.array([0.0, 0.0, 60.0 if fault == WORKSPACE else 8.0])))
        met[fault] += 1
        robot = reopen(robot)
    robot.close()
    return met
