"""The sensor's axes against the drill's, from touches of one wall with the flange turned: hand-eye for a plane.

Let X be the sensor's rotation in the flange, R_i the flange's in the base at touch i, s_i the wall's normal that the
sensor reads, and n the wall's in the base. Then

    R_i X s_i = n                                            (Shiu & Ahmad 1989, for one direction in place of a pose)

for all i, with three unknowns of X and two of n; each touch gives two equations. Turned about the drill's axis by
angles all around, the mean of the s_i is the drill's axis in the sensor's frame, whatever n is. Turns about one axis
alone leave X's turn about it open, for it could be the wall's as well; so the flange is leaned, too, both ways. What
a reading is off alike in all of them (seating, print) goes into X, and is taken out of every later reading near the
drill's axis.
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
"""Standard deviation of the sensor's rotation about each axis beforehand."""
_FAR = 5.0
"""Root mean square of what is left, over its standard deviation, above which touches are not of one wall."""


def find_tool_offset(tool: Tool, touches: Sequence[Touch], robot_deg: float) -> Tool:
    """The tool with its sensor turned as the touches of one flat wall say.

    Parameters
    ----------
    tool
        As designed.
    touches
        At least three, the flange turned about the drill's axis, and leaned, between them.
    robot_deg
        Standard deviation of the robot's turns about each axis.

    Raises
    ------
    PalpateError
        If there are fewer than three touches, or they do not fit one flat wall.
    """
    if len(touches) < 3:
        raise PalpateError(
            f"{len(touches)} touches do not tell the tool's offset.",
            "Touch three times or more.",
            code="tool-few-touches",
        )
    nominal = tool.flange_from_sensor.rotation
    first = touches[0].base_from_flange.rotation @ nominal @ wall_normal(*np.radians(touches[0].tilt_deg))
    side = np.linalg.svd(first[None])[2][1:]
    spread = [np.linalg.cholesky(touch.covariance + robot_deg**2 * np.eye(2)) for touch in touches]

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
            f"The touches do not fit one flat wall: they are {rms:.1f} standard deviations off.",
            "Touch one place of a flat wall, and check that the drill's axis is the one that was turned about.",
            code="tool-touches-misfit",
        )
    covariance = np.linalg.inv(fit.jac.T @ fit.jac)[:3, :3]
    placed = Placement(nominal @ rotation_from_vector(fit.x[:3]), tool.flange_from_sensor.position)
    return replace(tool, flange_from_sensor=placed, covariance=covariance)
