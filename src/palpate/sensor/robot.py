"""Interface of a robot: move the flange to a pose, and report its pose."""

from __future__ import annotations

from abc import ABC, abstractmethod

from palpate.sensor.placement import Placement


class Robot(ABC):
    """Robot that carries the sensor. Right-handed frames, mm; the flange's z points away from the robot.

    The constructor of a robot that is opened by a text has this text as its only argument.
    """

    @abstractmethod
    def move(self, base_from_flange: Placement) -> None:
        """Move the flange in a straight line to a pose, and return on arrival.

        Raises
        ------
        PalpateError
            If the pose cannot be reached, or the robot has stopped.
        """

    @abstractmethod
    def flange_pose(self) -> Placement:
        """Return the flange pose reported by the robot, ``base_from_flange``."""

    def announce(self, text: str) -> None:
        """Receive the next pose in words, before `move`; a robot that is moved manually shows it."""
        return

    def close(self) -> None:
        """Disconnect from the robot."""
        return
