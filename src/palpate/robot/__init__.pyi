"""Robot: the last metre: a tool that is squared to walls, the sensor's axes against the drill's, and ROS."""

from palpate.robot.align import OFFSET_TURNS, Aligner, NextImage
from palpate.robot.alignment import (
    TOUCH_COLUMNS,
    Alignment,
    AlignmentOutcome,
    Touch,
    describe_alignment,
    list_touches,
)
from palpate.robot.broadcast import Broadcast
from palpate.robot.open_by import SensorLaunchSpec, open_from_parameters, parse_launch_spec
from palpate.robot.placement import Placement, rotation_from_vector, tilt_from_normal
from palpate.robot.read_source import SourceReader
from palpate.robot.robot import Robot
from palpate.robot.ros_sensor import TOPICS, RosSensor, RosSpec
from palpate.robot.spec import AlignSpec
from palpate.robot.tool import Tool
from palpate.robot.tool_offset import find_tool_offset

__all__ = [
    "OFFSET_TURNS",
    "TOPICS",
    "TOUCH_COLUMNS",
    "AlignSpec",
    "Aligner",
    "Alignment",
    "AlignmentOutcome",
    "Broadcast",
    "NextImage",
    "Placement",
    "Robot",
    "RosSensor",
    "RosSpec",
    "SensorLaunchSpec",
    "SourceReader",
    "Tool",
    "Touch",
    "describe_alignment",
    "find_tool_offset",
    "list_touches",
    "open_from_parameters",
    "parse_launch_spec",
    "rotation_from_vector",
    "tilt_from_normal",
]
