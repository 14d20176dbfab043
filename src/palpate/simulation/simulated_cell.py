"""A simulated cell: a unit on a robot whose reported placement has errors, in front of a wall."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from palpate.calibration import CONTACT_STATE, Deviation
from palpate.core import FloatArray, PalpateError
from palpate.core.state import State
from palpate.design import TILT_SPACE
from palpate.sensor import Placement, rotation_from_vector
from palpate.simulation.backend import UnitBackend
from palpate.simulation.simulated_robot import SimulatedRobot
from palpate.simulation.spec import WorkpieceSpec
from palpate.surrogate import LATERAL

_REST_NOISES = 12
"""Number of noise seeds for rest images. By hand."""


@dataclass(frozen=True, eq=False)
class FlatWall:
    """Flat wall in the base's frame.

    Attributes
    ----------
    point
        (3,) mm on it.
    normal
        (3,) unit vector into it, away from the robot.
    inverse_friction
        1/µ between it and the dome.
    workpiece
        Its compliance.
    axis
        (3,) unit vector in the wall, about which it rotates under force.
    """

    point: FloatArray
    normal: FloatArray
    inverse_friction: float
    workpiece: WorkpieceSpec = field(default_factory=WorkpieceSpec)
    axis: FloatArray = field(default_factory=lambda: np.zeros(3))

    def under(self, force_n: float) -> FlatWall:
        """Return the wall under a force along its normal, about whose point it rotates."""
        turn = rotation_from_vector(self.workpiece.wall_tilt_compliance * force_n * self.axis)
        moved = self.point + self.workpiece.wall_compliance * force_n * self.normal
        return replace(self, point=moved, normal=turn @ self.normal)


class SimulatedCell:
    """Wall, unit and camera; returns images at the true placement of the robot.

    Parameters
    ----------
    backend
        The unit and its mechanics.
    wall
        Wall that is touched.
    flange_from_sensor
        True placement of the unit on the flange.
    unreadable
        Share of unreadable images.
    rng
        Random numbers of noise and unreadable images.

    Attributes
    ----------
    robot
        Robot that carries the unit; set after its construction.
    max_force_n
        Maximum force along the wall's normal so far.
    """

    robot: SimulatedRobot

    def __init__(
        self,
        backend: UnitBackend,
        wall: FlatWall,
        flange_from_sensor: Placement,
        unreadable: float,
        rng: np.random.Generator,
    ) -> None:
        self._backend, self._wall, self._mounted = backend, wall, flange_from_sensor
        self._unreadable, self._rng = unreadable, rng
        self._first: Placement | None = None
        self.max_force_n = 0.0

    def push(self, base_from_flange: Placement) -> FloatArray:
        """Return the force (3,) N on the flange at a true placement, base's frame; 0 ends a contact."""
        sensor = base_from_flange @ self._mounted
        pose = self._pose(sensor)
        if pose[2] <= 0.0:
            self._first = None
            return np.zeros(3)
        on_wall = sensor.rotation @ self._backend.force(self._contact(pose))
        return -on_wall

    def next_image(self) -> NDArray[Any] | PalpateError:
        """Return an image (h, w) at the robot's placement; an unreadable one is returned as an error."""
        sensor = self.robot.true_pose @ self._mounted
        pose = self._pose(sensor)
        unit = self._backend.unit
        if pose[2] <= 0.0:
            self._first = None
        else:
            self._first = self._first or sensor
            self._weigh()
        if self._rng.random() < self._unreadable:
            return PalpateError("The image was torn.", "Look again.", code="image-damaged")
        if pose[2] <= 0.0:
            return unit.render(unit.edges, int(self._rng.integers(_REST_NOISES)))
        edges = self._backend.edges(self._contact(pose).add(LATERAL, self._drift(sensor, pose)))
        return unit.render(edges, int(self._rng.integers(2**31)))

    def angle_deg(self, drill: FloatArray, force_n: float = 0.0) -> float:
        """True angle between the drill (3,) in the flange's frame and the normal of the wall under a force."""
        axis, normal = self.robot.true_pose.rotation @ drill, self._wall.under(force_n).normal
        return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(axis, normal)), axis @ normal)))

    def depth_at(self, base_from_flange: Placement) -> float:
        """Depth (mm) of the wall at a true placement of the flange; negative without contact."""
        return float(self._pose(base_from_flange @ self._mounted)[2])

    def _weigh(self) -> None:
        pressing = -float(self.push(self.robot.true_pose) @ self._wall.normal)
        self.max_force_n = max(self.max_force_n, pressing)

    def _pose(self, sensor: Placement) -> FloatArray:
        """rx, ry (degrees) and depth (mm) of the wall under a sensor; negative depths are no contact."""
        wall, workpiece = self._wall, self._wall.workpiece
        free = self._push_on(wall, sensor) if workpiece.wall_compliance or workpiece.wall_tilt_compliance else 0.0
        if free > 0.0:  # the force at which wall and skin are in equilibrium
            most = free
            while self._push_on(wall.under(most), sensor) > most:
                most *= 2.0
            found = brentq(lambda force: self._push_on(wall.under(force), sensor) - force, 0.0, most)
            wall = wall.under(float(found))
        return self._pose_before(wall, sensor)

    def _push_on(self, wall: FlatWall, sensor: Placement) -> float:
        """Return the force (N) along the normal of a rigid wall."""
        pose = self._pose_before(wall, sensor)
        if pose[2] <= 0.0:
            return 0.0
        return float(sensor.rotation @ self._backend.force(self._contact(pose)) @ wall.normal)

    def _pose_before(self, wall: FlatWall, sensor: Placement) -> FloatArray:
        unit = self._backend.unit
        return sensor.wall_pose(wall.point, wall.normal, unit.design.skin, unit.deviation.thickness)

    def _contact(self, pose: FloatArray) -> State:
        """Return the contact at a pose (3,), without motion in the plane of the wall."""
        contact = State.zeros(CONTACT_STATE).add(TILT_SPACE.names, pose)
        return contact.replace(inverse_friction=self._wall.inverse_friction)

    def _drift(self, sensor: Placement, pose: FloatArray) -> FloatArray:
        """Lateral motion and twist of the wall since first contact, in its own axes."""
        before = self._first or sensor
        moved = -sensor.rotation.T @ (sensor.position - before.position)
        normal = sensor.rotation.T @ self._wall.normal
        across = moved - (moved @ normal) / normal[2] * np.array([0.0, 0.0, 1.0])
        axes = _turned_axes(pose)
        relative = before.rotation.T @ sensor.rotation
        twist = -np.degrees(np.arctan2(relative[1, 0], relative[0, 0]))
        return np.array([across @ axes[:, 0], across @ axes[:, 1], twist])


def _turned_axes(pose: FloatArray) -> FloatArray:
    """The wall's x and y as columns (3, 2), in the skin's frame."""
    return rotation_from_vector(np.array([pose[0], pose[1], 0.0]))[:, :2]


def seat_unit(deviation: Deviation) -> FloatArray:
    """Rotation (3, 3) of the skin on its mount."""
    return rotation_from_vector(
        np.array([deviation.seating_x_deg, deviation.seating_y_deg, 0.0])
    ) @ rotation_from_vector(np.array([0.0, 0.0, deviation.seating_turn_deg]))
