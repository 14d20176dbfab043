"""Scaling of constants, measured on one skin and camera, to another skin and resolution.

A sensor with all lengths s times as large and the same number of pixels measures angles equally well. Its lengths
scale by s and its curvatures by 1/s. Twin error is proportional to the skin's size, so in pixels it scales with the
magnification. All constants hold for a skin of `SIZE_MM` before the camera of `CameraSpec`.
"""

from __future__ import annotations

import numpy as np

from palpate.calibration.noise import MODEL_ERROR_PX
from palpate.camera import CameraSpec
from palpate.core.state import State
from palpate.design import Skin

_LENGTH_POWER = {"depth_mm": 1, "curvature": -1, "lateral_x": 1, "lateral_y": 1}
"""Exponent of the skin's size by which an entry of a contact scales."""
SIZE_MM = 20.0
"""Radius of the skin on which the constants were measured, mm: H20 T2."""
_NOMINAL = CameraSpec()


def size_scale(skin: Skin) -> float:
    """Return the size of a skin relative to that of the constants."""
    return skin.widest[0] / SIZE_MM


def scale_contact(values: State, skin: Skin) -> State:
    """Scale entries of a contact from the skin of the constants to another skin."""
    size = size_scale(skin)
    factors = {0: 1.0, 1: size, -1: 1.0 / size}
    return State(values.names, values.values * [factors[_LENGTH_POWER.get(name, 0)] for name in values.names])


def pixel_scale(skin: Skin, camera: CameraSpec) -> float:
    """Return the pixels over a share of the skin's size, relative to skin and camera of the constants."""
    return size_scale(skin) * _magnify(camera, size_scale(skin)) / _magnify(_NOMINAL, 1.0)


def model_px(skin: Skin, camera: CameraSpec) -> float:
    """Return the twin error of a marker in an image, px."""
    return MODEL_ERROR_PX * pixel_scale(skin, camera)


def _magnify(camera: CameraSpec, size: float) -> float:
    """Return the pixels per mm at the apex of a skin as tall as wide."""
    return float(np.sqrt(camera.fx_px * camera.fy_px)) / (camera.distance + size * SIZE_MM)
