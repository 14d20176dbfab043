"""Tilt and depth of a flat wall from the pose of a robot's flange, and the reverse."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from palpate.core import FloatArray
from palpate.design import Skin, wall_normal
from palpate.sensor import Placement, rotation_from_vector


@dataclass(frozen=True, eq=False)
class PressFrame:
    """Frame of the presses of one wall.

    Attributes
    ----------
    start
        Pose of the flange, ``base_from_flange``, at which the upright skin just touches the wall.
    skin
        The skin.
    flange_from_sensor
        Pose of the sensor on the flange.
    """

    start: Placement
    skin: Skin
    flange_from_sensor: Placement = field(default_factory=Placement)

    @cached_property
    def _touched(self) -> Placement:
        """Pose of the wall: the sensor's axes at the start, with their origin at the touched point."""
        sensor = self.start @ self.flange_from_sensor
        return Placement(sensor.rotation, sensor.apply(self.skin.support_point(np.array([0.0, 0.0, 1.0]))))

    def flange_at(self, pose: FloatArray) -> Placement:
        """Return the flange pose that presses the wall at rx, ry (degrees) and depth (mm), (3,).

        The skin touches the same point of the wall at every tilt, and moves along its axis from there.
        """
        wall = self._touched
        rotation = wall.rotation @ rotation_from_vector(np.array([pose[0], pose[1], 0.0])).T
        touching = self.skin.support_point(wall_normal(*np.radians(pose[:2])))
        sensor = Placement(rotation, wall.position - rotation @ touching + pose[2] * rotation[:, 2])
        return sensor @ self.flange_from_sensor.inverse()

    def pose_at(self, base_from_flange: Placement) -> FloatArray:
        """Return rx, ry (degrees) and depth (mm) of the wall, (3,), at a flange pose."""
        wall = self._touched
        sensor = base_from_flange @ self.flange_from_sensor
        return sensor.wall_pose(wall.position, wall.rotation[:, 2], self.skin)
