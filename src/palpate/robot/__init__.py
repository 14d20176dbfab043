"""Robot: the last metre: a tool that is squared to walls, the sensor's axes against the drill's, and ROS."""

from palpate.robot.align import OFFSET_TURNS, Aligner, NextImage
from palpate.robot.alignment import Alignment, Ending, Touch
from palpate.robot.broadcast import Broadcast
from palpate.robot.open_by import OpenSpec, open_by, read_open_spec
from palpate.robot.placement import Placement, tilt_of
from palpate.robot.play import Play, PlayedUnit, PlayedWall
from palpate.robot.read_source import SourceReader
from palpate.robot.robot import Robot
from palpate.robot.ros_sensor import TOPICS, RosSensor, RosSpec
from palpate.robot.simulated_robot import SimulatedRobot
from palpate.robot.spec import AlignSpec, SimulatedRobotSpec
from palpate.robot.tool import Tool
from palpate.robot.tool_offset import find_tool_offset
from palpate.robot.write_alignment import describe_alignment, describe_wall, list_touches, write_alignments

__all__ = [
    "OFFSET_TURNS",
    "TOPICS",
    "AlignSpec",
    "Aligner",
    "Alignment",
    "Broadcast",
    "Ending",
    "NextImage",
    "OpenSpec",
    "Placement",
    "Play",
    "PlayedUnit",
    "PlayedWall",
    "Robot",
    "RosSensor",
    "RosSpec",
    "SimulatedRobot",
    "SimulatedRobotSpec",
    "SourceReader",
    "Tool",
    "Touch",
    "describe_alignment",
    "describe_wall",
    "find_tool_offset",
    "list_touches",
    "open_by",
    "read_open_spec",
    "tilt_of",
    "write_alignments",
]
