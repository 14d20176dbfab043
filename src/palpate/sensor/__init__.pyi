"""Sensor: a built unit at work: readings of its images, its acceptance, robots that it guides, ROS messages."""

from palpate.sensor.accept import accept_unit
from palpate.sensor.align import Aligner
from palpate.sensor.alignment import (
    TOUCH_COLUMNS,
    Alignment,
    AlignmentOutcome,
    describe_alignment,
    list_touches,
)
from palpate.sensor.broadcast import Broadcast
from palpate.sensor.certificate import Certificate
from palpate.sensor.depth_zero import DepthZero, find_depth_zero
from palpate.sensor.device import Device
from palpate.sensor.draw_inspection import draw_inspection
from palpate.sensor.gauge_study import GaugeStudy
from palpate.sensor.identify_unit import identify_unit
from palpate.sensor.inspect_unit import Inspection, inspect_unit
from palpate.sensor.open_from_parameters import SensorLaunchSpec, open_from_parameters, parse_launch_spec
from palpate.sensor.placement import Placement, rotation_from_vector, tilt_from_normal
from palpate.sensor.pose_estimator import check_model, open_model
from palpate.sensor.read_source import SourceReader
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.recording import GroundTruth, read_ground_truth, read_readings
from palpate.sensor.reference_press import ReferencePress
from palpate.sensor.reference_standard import ReferenceSpec
from palpate.sensor.report import provenance_line, write_report
from palpate.sensor.robot import Robot
from palpate.sensor.robot_spec import AlignSpec
from palpate.sensor.ros_image import Level, camera_info, diagnostics, image_message
from palpate.sensor.ros_message import Message, build_message, header_of
from palpate.sensor.ros_reading import dots_message, pose_message, pose_with_covariance, wrench_stamped
from palpate.sensor.ros_sensor import TOPICS, RosSensor, RosSpec
from palpate.sensor.score import PAPER_TABLE_3, Score, score_readings
from palpate.sensor.sensor import Sensor, open_sensor, run_sensor
from palpate.sensor.spec import AcceptanceSpec, InspectionSpec, SensorSpec
from palpate.sensor.tool import Tool
from palpate.sensor.tool_offset import find_tool_offset
from palpate.sensor.unit import Unit
from palpate.sensor.write_identification import write_identification
from palpate.sensor.write_readings import describe_reading, write_readings

__all__ = [
    "PAPER_TABLE_3",
    "TOPICS",
    "TOUCH_COLUMNS",
    "AcceptanceSpec",
    "AlignSpec",
    "Aligner",
    "Alignment",
    "AlignmentOutcome",
    "Broadcast",
    "Certificate",
    "DepthZero",
    "Device",
    "Flag",
    "GaugeStudy",
    "GroundTruth",
    "Inspection",
    "InspectionSpec",
    "Level",
    "Message",
    "Placement",
    "Reading",
    "ReferencePress",
    "ReferenceSpec",
    "Robot",
    "RosSensor",
    "RosSpec",
    "Score",
    "Sensor",
    "SensorLaunchSpec",
    "SensorSpec",
    "SourceReader",
    "Tool",
    "Unit",
    "accept_unit",
    "build_message",
    "camera_info",
    "check_model",
    "describe_alignment",
    "describe_reading",
    "diagnostics",
    "dots_message",
    "draw_inspection",
    "find_depth_zero",
    "find_tool_offset",
    "header_of",
    "identify_unit",
    "image_message",
    "inspect_unit",
    "list_touches",
    "open_from_parameters",
    "open_model",
    "open_sensor",
    "parse_launch_spec",
    "pose_message",
    "pose_with_covariance",
    "provenance_line",
    "read_ground_truth",
    "read_readings",
    "rotation_from_vector",
    "run_sensor",
    "score_readings",
    "tilt_from_normal",
    "wrench_stamped",
    "write_identification",
    "write_readings",
    "write_report",
]
