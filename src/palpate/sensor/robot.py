"""What a robot must be able to do: move its flange to a placement, and say where it is."""

from __future__ import annotations

from abc import ABC, abstractmethod

from palpate.sensor.placement import Placement


class Robot(ABC):
    """A robot that carries the sensor. Right-handed frames, mm; the flange's z points away from the robot."""

    @abstractmethod
    def move(self, base_from_flange: Placement) -> None:
        """Move in a straight line to a placement of the flange, and return when there.

        Raises
        ------
        PalpateError
            If it cannot get there, or has stopped.
        """

    @abstractmethod
    def flange_pose(self) -> Placement:
        """Where the robot says that its flange is, ``base_from_flange``."""
