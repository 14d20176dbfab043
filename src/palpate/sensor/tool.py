"""The tool on the flange: where its sensor sits, and which way its drill points."""

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
    """A sensor and a drill on one flange.

    Attributes
    ----------
    flange_from_sensor
        Where the sensor's frame stands: its origin is the middle of the dome's base, its z the dome's axis, outward.
    drill
        (3,) unit vector, flange's frame: the way the drill feeds, and the axis about which the flange is turned.
    covariance
        (3, 3) deg² of a rotation vector of the sensor about its own axes: how well its rotation is known.
    """

    flange_from_sensor: Placement = field(default_factory=Placement)
    drill: FloatArray = field(default_factory=_along_z)
    covariance: FloatArray = field(default_factory=_known)

    @property
    def drill_in_sensor(self) -> FloatArray:
        """(3,) the drill's axis in the sensor's frame."""
        return self.flange_from_sensor.rotation.T @ self.drill
