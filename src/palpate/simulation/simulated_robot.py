"""Simulated robot with errors of each move, backlash, and compliance under contact force."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray
from palpate.sensor import Placement, Robot, rotation_from_vector
from palpate.simulation.spec import SimulatedRobotSpec

_SAME = 1e-9
"""Motion (mm or degrees) that counts as none."""
_ROUNDS = 30
"""Maximum iterations between force and compliance.

Each removes most of the residual if the robot is stiffer than the skin. By hand.
"""


@final
class SimulatedRobot(Robot):
    """Robot whose true placement is known to the simulation only.

    A position error is drawn for every move, a rotation error for every commanded rotation: a straight press keeps
    its rotation error.

    Parameters
    ----------
    start
        Initial placement, without error.
    spec
        Errors of the robot.
    rng
        Random numbers of its errors.
    push
        Force (3,) N on the flange at a true placement, base's frame.
    """

    def __init__(
        self,
        start: Placement,
        spec: SimulatedRobotSpec,
        rng: np.random.Generator,
        push: Callable[[Placement], FloatArray],
    ) -> None:
        self._spec, self._rng, self._push = spec, rng, push
        self._said = self._true = start
        self._turn_error, self._side, self._turn_side = np.eye(3), np.zeros(3), np.zeros(3)

    def move(self, base_from_flange: Placement) -> None:
        spec, turned = self._spec, self._said.rotation.T @ base_from_flange.rotation
        way = Rotation.from_matrix(turned).as_rotvec(degrees=True)
        if np.abs(way).max() > _SAME:
            self._turn_side = np.where(np.abs(way) > _SAME, np.sign(way), self._turn_side)
            off = self._rng.normal(0.0, spec.rotation_sd_deg, 3) - 0.5 * spec.backlash_deg * self._turn_side
            self._turn_error = rotation_from_vector(off)
        along = base_from_flange.position - self._said.position
        self._side = np.where(np.abs(along) > _SAME, np.sign(along), self._side)
        off = self._rng.normal(0.0, spec.position_sd_mm, 3) - 0.5 * spec.backlash_mm * self._side
        self._said = base_from_flange
        free = Placement(base_from_flange.rotation @ self._turn_error, base_from_flange.position + off)
        self._true = self._yield(free)

    def _yield(self, free: Placement) -> Placement:
        """Return the equilibrium placement under the contact force."""
        back = np.zeros(3)
        for _ in range(_ROUNDS):
            again = self._spec.compliance * self._push(free.moved(back))
            if np.abs(again - back).max() < _SAME:
                break
            back = again
        return free.moved(back)

    def flange_pose(self) -> Placement:
        return self._said

    @property
    def true_pose(self) -> Placement:
        """True placement."""
        return self._true
