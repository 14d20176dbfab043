"""Construction of a camera from its spec."""

from __future__ import annotations

import numpy as np

from palpate.camera.camera import Camera
from palpate.camera.lens import make_lens
from palpate.camera.spec import CameraSpec
from palpate.camera.window import Window
from palpate.core import FloatArray


def build_camera(spec: CameraSpec | None = None) -> Camera:
    """Build the camera of `spec`; without one, the paper's DAVIS 346.

    The camera is rotated in the skin's frame about x, then y, and rolled about its own optical axis:
    dome_from_camera = R_y(tilt_y) R_x(tilt_x) R_z(roll).

    Examples
    --------
    >>> build_camera().project([0.0, 0.0, 20.0]).round(2).tolist()
    [174.91, 128.22]
    """
    spec = spec or CameraSpec()
    dome_from_camera = (
        _turn(1, spec.tilt_y_deg) @ _turn(0, spec.tilt_x_deg) @ _turn(2, spec.roll_deg)
    )  # the rightmost acts first, in the camera's own axes
    return Camera(
        spec=spec,
        lens=make_lens(spec.lens, spec.distortion),
        camera_from_dome=dome_from_camera.T,
        origin=np.array([spec.offset_x, spec.offset_y, -spec.distance]),
        window=Window(**spec.window.model_dump()) if spec.window is not None else None,
    )


def _turn(axis: int, angle_deg: float) -> FloatArray:
    """Return the rotation matrix about one axis of the frame, right-handed."""
    angle = np.radians(angle_deg)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[a, a] = matrix[b, b] = np.cos(angle)
    matrix[b, a], matrix[a, b] = np.sin(angle), -np.sin(angle)
    return matrix
