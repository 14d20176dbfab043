"""Sensor: a built unit at work: from its images to readings, with what may be wrong about them."""

from palpate.sensor.draw_inspection import draw_inspection
from palpate.sensor.inspect_unit import Inspection, InspectSpec, inspect_unit
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.register import Registration, register_dome
from palpate.sensor.sensor import Rest, Sensor, Unit, open_sensor, read_rest, run_sensor
from palpate.sensor.spec import RigSpec
from palpate.sensor.write_readings import describe_reading, write_readings

__all__ = [
    "Flag",
    "InspectSpec",
    "Inspection",
    "Reading",
    "Registration",
    "Rest",
    "RigSpec",
    "Sensor",
    "Unit",
    "describe_reading",
    "draw_inspection",
    "inspect_unit",
    "open_sensor",
    "read_rest",
    "register_dome",
    "run_sensor",
    "write_readings",
]
