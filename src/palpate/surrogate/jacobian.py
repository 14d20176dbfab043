"""Derivative of the image by the pose."""

from __future__ import annotations

import numpy as np

from palpate.camera import Camera
from palpate.core import FloatArray, PalpateError
from palpate.surrogate.press_field import PressField

ANGLE_STEP_DEG = 0.25
"""Half the difference of a rotation, degrees. By hand."""


def image_jacobian(
    field: PressField, camera: Camera, rotations_deg: FloatArray, depth_index: int, step_deg: float = ANGLE_STEP_DEG
) -> FloatArray:
    """Compute the derivative of every pixel coordinate by the pose, ∂U/∂(rx, ry, depth).

    Central differences of the interpolated field: `step_deg` in the angles, one depth step in depth (at the last
    depth: three points backwards).

    Parameters
    ----------
    field
        Positions of the markers.
    camera
        Camera of the markers.
    rotations_deg
        (n, 2) rx and ry.
    depth_index
        Index of the depth in `field.depths_mm`, at least 1; at least 2 if it is the last.
    step_deg
        Half-width of the differences in rx and ry (degrees).

    Returns
    -------
    FloatArray
        (n, 2m, 3): px per degree, px per degree, px per mm. NaN if a neighbouring pose is out of reach or on another
        branch.
    """
    last = len(field.depths_mm) - 1
    if not min(2, last) <= depth_index <= last and not 1 <= depth_index < last:
        raise PalpateError(
            f"Image {depth_index} of {last + 1} has too few neighbours in depth.",
            "Press deeper.",
            code="image-few-neighbours",
        )

    def pixels(turn_x: float, turn_y: float, depth: int) -> FloatArray:
        poses = rotations_deg + np.array([turn_x, turn_y])
        labels, _ = field.labels(np.hypot(poses[:, 0], poses[:, 1]), depth)
        seen: FloatArray = camera.project(field.positions(poses[:, 0], poses[:, 1], depth)).reshape(len(poses), -1)
        seen[labels != here] = np.nan
        return seen

    here, _ = field.labels(np.hypot(rotations_deg[:, 0], rotations_deg[:, 1]), depth_index)
    by_rx = (pixels(step_deg, 0, depth_index) - pixels(-step_deg, 0, depth_index)) / (2 * step_deg)
    by_ry = (pixels(0, step_deg, depth_index) - pixels(0, -step_deg, depth_index)) / (2 * step_deg)
    spacing = field.depths_mm[depth_index] - field.depths_mm[depth_index - 1]
    if depth_index < last:
        by_depth = (pixels(0, 0, depth_index + 1) - pixels(0, 0, depth_index - 1)) / (2 * spacing)
    else:
        by_depth = (
            1.5 * pixels(0, 0, depth_index) - 2 * pixels(0, 0, depth_index - 1) + 0.5 * pixels(0, 0, depth_index - 2)
        )
        by_depth /= spacing
    return np.stack([by_rx, by_ry, by_depth], axis=-1)
