"""Rig: acquisition of a recording by a robot, or manually, and choice of its presses."""

from palpate.rig.acquisition import Acquisition
from palpate.rig.camera_check_spec import CameraCheckSpec
from palpate.rig.camera_controls import find_automatic_controls
from palpate.rig.check_camera import CameraCheck, CameraFigure, check_camera
from palpate.rig.check_image import NextImage, find_image_fault, images_of, take_image
from palpate.rig.manual_robot import ManualRobot
from palpate.rig.next_press import choose_next_press
from palpate.rig.press_frame import PressFrame
from palpate.rig.recording_folder import RecordingFolder
from palpate.rig.robots import ROBOTS, open_robot
from palpate.rig.take_spec import PlannedPress, TakeSpec

__all__ = [
    "ROBOTS",
    "Acquisition",
    "CameraCheck",
    "CameraCheckSpec",
    "CameraFigure",
    "ManualRobot",
    "NextImage",
    "PlannedPress",
    "PressFrame",
    "RecordingFolder",
    "TakeSpec",
    "check_camera",
    "choose_next_press",
    "find_automatic_controls",
    "find_image_fault",
    "images_of",
    "open_robot",
    "take_image",
]
