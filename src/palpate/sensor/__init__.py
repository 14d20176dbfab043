"""Sensor: a built unit at work: from its images to readings, with what may be wrong about them."""

from palpate.sensor.accept import AcceptSpec, accept_unit
from palpate.sensor.device import Device
from palpate.sensor.draw_inspection import draw_inspection
from palpate.sensor.identify_unit import identify_unit
from palpate.sensor.inspect_unit import Inspection, InspectSpec, inspect_unit
from palpate.sensor.known_press import KnownPress
from palpate.sensor.reader import check_model, open_model
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.recording import Truth, read_readings, read_truth
from palpate.sensor.register import Registration, register_dome
from palpate.sensor.report import made_by, table_lines, write_report
from palpate.sensor.score import PAPER_TABLE_3, Score, score_readings
from palpate.sensor.sensor import Sensor, open_sensor, run_sensor
from palpate.sensor.spec import RigSpec
from palpate.sensor.touch import TouchZero, find_zero
from palpate.sensor.unit import Unit
from palpate.sensor.write_acceptance import write_acceptance
from palpate.sensor.write_identification import write_identification
from palpate.sensor.write_readings import describe_reading, write_readings

__all__ = [
    "PAPER_TABLE_3",
    "AcceptSpec",
    "Device",
    "Flag",
    "InspectSpec",
    "Inspection",
    "KnownPress",
    "Reading",
    "Registration",
    "RigSpec",
    "Score",
    "Sensor",
    "TouchZero",
    "Truth",
    "Unit",
    "accept_unit",
    "check_model",
    "describe_reading",
    "draw_inspection",
    "find_zero",
    "identify_unit",
    "inspect_unit",
    "made_by",
    "open_model",
    "open_sensor",
    "read_readings",
    "read_truth",
    "register_dome",
    "run_sensor",
    "score_readings",
    "table_lines",
    "write_acceptance",
    "write_identification",
    "write_readings",
    "write_report",
]
