"""A tactile sensor as a camera of LeRobot, type `palpate`; LeRobot finds this package by its name."""

from lerobot_camera_palpate.camera import PalpateCamera
from lerobot_camera_palpate.config import PalpateCameraConfig

__all__ = ["PalpateCamera", "PalpateCameraConfig"]
