"""What was measured on one dome by one camera, scaled to another skin and resolution.

A sensor of which every length is s times as great, seen in as many pixels, reads the same angles as well: lengths in
its constants are s times as great, curvatures 1/s. What a twin is off is a share of its skin's size, so in pixels it
grows with the magnification. All are as measured for a skin of `SIZE_MM` before the camera of `CameraSpec`.
"""

from __future__ import annotations

import numpy as np

from palpate.built.noise import MODEL_ERROR_PX
from palpate.camera import CameraSpec
from palpate.core import FloatArray
from palpate.design import Skin

SIZE_MM = 20.0
"""Reach of the skin from its axis by which the constants were measured, mm: H20 T2."""
_NOMINAL = CameraSpec()


def size_scale(skin: Skin) -> float:
    """How many times as great a skin is as that of the constants."""
    return skin.widest[0] / SIZE_MM


def touch_scale(skin: Skin) -> FloatArray:
    """Factors (8,) for the numbers of `CONTACT_STATE`: depth and travel are lengths, the wall's curvature is 1 over
    one."""
    size = size_scale(skin)
    return np.array([1.0, 1.0, size, 1.0, 1.0 / size, size, size, 1.0])


def pixel_scale(skin: Skin, camera: CameraSpec) -> float:
    """How many times as many pixels a share of the skin's size is as with skin and camera of the constants."""
    return size_scale(skin) * _magnify(camera, size_scale(skin)) / _magnify(_NOMINAL, 1.0)


def model_px(skin: Skin, camera: CameraSpec) -> float:
    """What the twin itself may be off in an image, px."""
    return MODEL_ERROR_PX * pixel_scale(skin, camera)


def _magnify(camera: CameraSpec, size: float) -> float:
    """Pixels over mm at the apex of a skin as tall as wide."""
    return float(np.sqrt(camera.fx_px * camera.fy_px)) / (camera.distance + size * SIZE_MM)
