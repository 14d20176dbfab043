"""Scaling of constants, measured on one skin and camera, to another skin and resolution.

A sensor with all lengths s times as large and the same number of pixels measures angles equally well. Its lengths
scale by s and its curvatures by 1/s. Twin error is proportional to the skin's size, so in pixels it scales with the
magnification. All constants hold for a skin of size 1 (`Skin.size`) before the camera of `CameraSpec`.
"""

from __future__ import annotations

import numpy as np

from palpate.calibration.noise import MODEL_ERROR_PX
from palpate.camera import CameraSpec
from palpate.core.state import State
from palpate.design import Skin

_LENGTH_POWER = {"depth_mm": 1, "curvature": -1, "lateral_x": 1, "lateral_y": 1}
"""Exponent of the skin's size by which an entry of a contact scales."""
_NOMINAL = CameraSpec()


def scale_contact(values: State, skin: Skin) -> State:
    """Scale entries of a contact from the skin of the constants to another skin."""
    factors = {0: 1.0, 1: skin.size, -1: 1.0 / skin.size}
    return State(values.names, values.values * [factors[_LENGTH_POWER.get(name, 0)] for name in values.names])


def pixel_scale(skin: Skin, camera: CameraSpec) -> float:
    """Return the pixels over a share of the skin's size, relative to skin and camera of the constants."""
    radius = skin.widest[0]
    return skin.size * _magnify(camera, radius) / _magnify(_NOMINAL, radius / skin.size)


def model_px(skin: Skin, camera: CameraSpec) -> float:
    """Return the twin error of a marker in an image, px."""
    return MODEL_ERROR_PX * pixel_scale(skin, camera)


def _magnify(camera: CameraSpec, height: float) -> float:
    """Return the pixels per mm at a height (mm) over the base: the apex of a skin as tall as wide."""
    return float(np.sqrt(camera.fx_px * camera.fy_px)) / (camera.distance + height)
