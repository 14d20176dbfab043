"""What was measured on one dome by one camera, scaled to another skin and resolution.

A sensor of which every length is s times as great, seen in as many pixels, reads the same angles as well: lengths in
its constants are s times as great, curvatures 1/s. What a twin is off is a share of its skin's size, so in pixels it
grows with the magnification. All are as measured for a skin of `SIZE_MM` before the camera of `CameraSpec`.
"""

from __future__ import annotations

import numpy as np

from palpate.calibration.noise import MODEL_ERROR_PX
from palpate.camera import CameraSpec
from palpate.core.state import State
from palpate.design import Skin

_LENGTH_POWER = {"depth_mm": 1, "curvature": -1, "lateral_x": 1, "lateral_y": 1}
"""Entry of a contact → power of the skin's size with which it grows."""
SIZE_MM = 20.0
"""Reach of the skin from its axis by which the constants were measured, mm: H20 T2."""
_NOMINAL = CameraSpec()


def size_scale(skin: Skin) -> float:
    """How many times as great a skin is as that of the constants."""
    return skin.widest[0] / SIZE_MM


def scale_contact(values: State, skin: Skin) -> State:
    """Return entries of a contact, measured on the skin of the constants, for another skin."""
    size = size_scale(skin)
    factors = {0: 1.0, 1: size, -1: 1.0 / size}
    return State(values.names, values.values * [factors[_LENGTH_POWER.get(name, 0)] for name in values.names])


def pixel_scale(skin: Skin, camera: CameraSpec) -> float:
    """How many times as many pixels a share of the skin's size is as with skin and camera of the constants."""
    return size_scale(skin) * _magnify(camera, size_scale(skin)) / _magnify(_NOMINAL, 1.0)


def model_px(skin: Skin, camera: CameraSpec) -> float:
    """What the twin itself may be off in an image, px."""
    return MODEL_ERROR_PX * pixel_scale(skin, camera)


def _magnify(camera: CameraSpec, size: float) -> float:
    """Pixels over mm at the apex of a skin as tall as wide."""
    return float(np.sqrt(camera.fx_px * camera.fy_px)) / (camera.distance + size * SIZE_MM)
