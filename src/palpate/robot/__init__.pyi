"""Robot: the last metre: a tool that is squared to walls, the sensor's axes against the drill's, and ROS."""

from palpate.robot.align import OFFSET_TURNS, Aligner, NextImage
from palpate.robot.alignment import Alignment, AlignmentOutcome, Touch
from palpate.robot.broadcast import Broadcast
from palpate.robot.open_by import SensorLaunchSpec, open_from_parameters, parse_launch_spec
from palpate.robot.placement import Placement, tilt_from_normal
from palpate.robot.play import AlignmentScenario, AlignmentTrial, VirtualUnit
from palpate.robot.read_source import SourceReader
from palpate.robot.robot import Robot
from palpate.robot.ros_sensor import TOPICS, RosSensor, RosSpec
from palpate.robot.simulated_robot import SimulatedRobot
from palpate.robot.spec import AlignSpec, SimulatedRobotSpec
from palpate.robot.tool import Tool
from palpate.robot.tool_offset import find_tool_offset
from palpate.robot.write_alignment import (
    describe_alignment,
    describe_wall,
    list_touches,
    list_wall_touches,
    write_alignments,
)

__all__ = [
    "OFFSET_TURNS",
    "TOPICS",
    "AlignSpec",
    "Aligner",
    "Alignment",
    "AlignmentOutcome",
    "AlignmentScenario",
    "AlignmentTrial",
    "Broadcast",
    "NextImage",
    "Placement",
    "Robot",
    "RosSensor",
    "RosSpec",
    "SensorLaunchSpec",
    "SimulatedRobot",
    "SimulatedRobotSpec",
    "SourceReader",
    "Tool",
    "Touch",
    "VirtualUnit",
    "describe_alignment",
    "describe_wall",
    "find_tool_offset",
    "list_touches",
    "list_wall_touches",
    "open_from_parameters",
    "parse_launch_spec",
    "tilt_from_normal",
    "write_alignments",
]
