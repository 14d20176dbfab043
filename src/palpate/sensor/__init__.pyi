"""Sensor: a built unit at work: from its images to readings, with what may be wrong about them."""

from palpate.sensor.accept import AcceptanceSpec, accept_unit
from palpate.sensor.device import Device
from palpate.sensor.draw_inspection import draw_inspection
from palpate.sensor.identify_unit import identify_unit
from palpate.sensor.inspect_unit import Inspection, InspectionSpec, inspect_unit
from palpate.sensor.known_press import ReferencePress
from palpate.sensor.reader import check_model, open_model
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.recording import GroundTruth, read_ground_truth, read_readings
from palpate.sensor.report import provenance_line, write_report
from palpate.sensor.score import PAPER_TABLE_3, Score, score_readings
from palpate.sensor.sensor import Sensor, open_sensor, run_sensor
from palpate.sensor.spec import SensorSpec
from palpate.sensor.touch import DepthZero, find_depth_zero
from palpate.sensor.unit import Unit
from palpate.sensor.write_acceptance import acceptance_page, write_acceptance
from palpate.sensor.write_identification import write_identification
from palpate.sensor.write_readings import describe_reading, write_readings

__all__ = [
    "PAPER_TABLE_3",
    "AcceptanceSpec",
    "DepthZero",
    "Device",
    "Flag",
    "GroundTruth",
    "Inspection",
    "InspectionSpec",
    "Reading",
    "ReferencePress",
    "Score",
    "Sensor",
    "SensorSpec",
    "Unit",
    "accept_unit",
    "acceptance_page",
    "check_model",
    "describe_reading",
    "draw_inspection",
    "find_depth_zero",
    "identify_unit",
    "inspect_unit",
    "open_model",
    "open_sensor",
    "provenance_line",
    "read_ground_truth",
    "read_readings",
    "run_sensor",
    "score_readings",
    "write_acceptance",
    "write_identification",
    "write_readings",
    "write_report",
]
