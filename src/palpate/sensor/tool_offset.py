"""Sensor rotation relative to the drill by presses of one wall: hand-eye calibration for a plane.

Let X be the sensor's rotation in the flange, R_i the flange's in the base at press i, s_i the wall normal measured by
the sensor, and n the wall normal in the base. Then

    R_i X s_i = n                                            (Shiu & Ahmad 1989, for one direction in place of a pose)

for all i, with three unknowns of X and two of n; each press gives two equations. If the flange is rotated all around
the drill's axis, the mean of the s_i is the drill's axis in the sensor's frame, for any n. Rotations about one axis
alone leave the rotation of X about it undetermined, so the flange is also tilted, in both directions. A reading error
common to all presses (seating, print) is included in X and thus removed from later readings near the drill's axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from palpate.core import FloatArray, PalpateError
from palpate.design import wall_normal
from palpate.sensor.alignment import Touch
from palpate.sensor.placement import Placement, rotation_from_vector, tilt_from_normal
from palpate.sensor.tool import Tool

_PRIOR_DEG = 3.0
"""Prior standard deviation of the sensor's rotation about each axis. By hand."""
_FAR = 5.0
"""Maximum RMS residual, in standard deviations, of presses of one wall. By hand."""


def find_tool_offset(tool: Tool, touches: Sequence[Touch], robot_deg: float) -> Tool:
    """Fit the sensor's rotation on the flange to presses of one flat wall.

    At least three presses are needed, between which the flange was rotated about the drill's axis and tilted;
    `robot_deg` is the standard deviation of the robot's rotations about each axis.

    Raises
    ------
    PalpateError
        If there are fewer than three presses, or they do not fit one flat wall.
    """
    if len(touches) < 3:
        raise PalpateError(
            f"{len(touches)} presses do not determine the tool offset.",
            "Press at least three times.",
            code="tool-few-touches",
        )
    nominal = tool.flange_from_sensor.rotation
    first = touches[0].base_from_flange.rotation @ nominal @ wall_normal(*np.radians(touches[0].tilt_deg))
    side = np.linalg.svd(first[None])[2][1:]
    spread = [np.linalg.cholesky(touch.tilt_covariance + robot_deg**2 * np.eye(2)) for touch in touches]

    def miss(values: FloatArray) -> FloatArray:
        turned = nominal @ rotation_from_vector(values[:3])
        normal = first + np.radians(values[3:]) @ side
        normal = normal / np.linalg.norm(normal)
        left = [
            np.linalg.solve(
                each, touch.tilt_deg - tilt_from_normal((touch.base_from_flange.rotation @ turned).T @ normal)
            )
            for touch, each in zip(touches, spread, strict=True)
        ]
        return np.concatenate([*left, values[:3] / _PRIOR_DEG])

    fit = least_squares(miss, np.zeros(5), x_scale=1.0)
    left = fit.fun[:-3]
    rms = float(np.sqrt(np.sum(left**2) / max(len(left) - 4, 1)))
    if rms > _FAR:
        raise PalpateError(
            f"The presses do not fit one flat wall: their residual is {rms:.1f} standard deviations.",
            "Press one place of a flat wall, and check that the flange was rotated about the drill's axis.",
            code="tool-touches-misfit",
        )
    covariance = np.linalg.inv(fit.jac.T @ fit.jac)[:3, :3]
    placed = Placement(nominal @ rotation_from_vector(fit.x[:3]), tool.flange_from_sensor.position)
    return replace(tool, flange_from_sensor=placed, covariance=covariance)
