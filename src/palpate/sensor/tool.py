"""Tool on the flange: pose of its sensor, and direction of its drill."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from palpate.core import FloatArray
from palpate.sensor.placement import Placement


def _along_z() -> FloatArray:
    return np.array([0.0, 0.0, 1.0])


def _known() -> FloatArray:
    return np.zeros((3, 3))


@dataclass(frozen=True, eq=False)
class Tool:
    """Sensor and drill on one flange.

    Attributes
    ----------
    flange_from_sensor
        Pose of the sensor's frame, whose origin is the centre of the skin's base and whose z is the skin's axis,
        outward.
    drill
        (3,) unit vector in the flange's frame: feed direction of the drill, and axis of the flange's rotations.
    covariance
        (3, 3) deg² of the sensor's rotation, as a rotation vector about its own axes.
    """

    flange_from_sensor: Placement = field(default_factory=Placement)
    drill: FloatArray = field(default_factory=_along_z)
    covariance: FloatArray = field(default_factory=_known)

    @property
    def drill_in_sensor(self) -> FloatArray:
        """Drill's axis (3,) in the sensor's frame."""
        return self.flange_from_sensor.rotation.T @ self.drill
