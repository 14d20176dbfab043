"""Robots by name; other packages register more."""

from __future__ import annotations

from typing import Any

from palpate.core import PalpateError, Registry
from palpate.sensor import Robot

ROBOTS: Registry[type[Robot]] = Registry(
    "palpate.robots",
    "robot",
    {
        "manual": "palpate.rig.manual_robot:ManualRobot",
        "ros2": "palpate.rig.ros_robot:RosRobot",
        "tcp": "palpate.rig.tcp_robot:TcpRobot",
        "ur": "palpate.rig.ur_robot:UrRobot",
    },
    fits=lambda found: isinstance(found, type) and issubclass(found, Robot),
    remedy="`simulated` is a simulated unit; a package with an entry point in the group palpate.robots adds another.",
)
"""Robots by name."""


def open_robot(text: str) -> Robot:
    """Open a robot by its name and, after a colon, the text of its constructor, such as an address.

    Raises
    ------
    PalpateError
        If the name is unknown, or the robot cannot be reached.
    """
    name, _, rest = text.partition(":")
    kind: Any = ROBOTS.get(name)
    try:
        robot: Robot = kind(rest)
    except PalpateError:
        raise
    except Exception as error:  # a robot's library may raise anything
        raise PalpateError.of(error) from error
    return robot
