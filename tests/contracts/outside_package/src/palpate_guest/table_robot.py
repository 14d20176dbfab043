"""A robot that knows no errors and keeps within a reach."""

import numpy as np

from palpate.core import PalpateError
from palpate.sensor import Placement, Robot


class TableRobot(Robot):
    def __init__(self, reach_mm=500.0):
        self._reach, self._there = reach_mm, Placement()

    def move(self, base_from_flange):
        if np.linalg.norm(base_from_flange.position) > self._reach:
            raise PalpateError(f"The placement is beyond {self._reach:g} mm.", "Move closer.", code="out-of-reach")
        self._there = base_from_flange

    def flange_pose(self):
        return self._there
