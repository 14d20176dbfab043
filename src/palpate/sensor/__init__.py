"""Sensor: a built unit at work: from its images to readings, with what may be wrong about them."""

from palpate.sensor.reading import Flag, Reading
from palpate.sensor.register import Registration, register_dome
from palpate.sensor.sensor import Sensor, Unit, open_sensor, run_sensor
from palpate.sensor.spec import RigSpec
from palpate.sensor.write_readings import describe_reading, write_readings

__all__ = [
    "Flag",
    "Reading",
    "Registration",
    "RigSpec",
    "Sensor",
    "Unit",
    "describe_reading",
    "open_sensor",
    "register_dome",
    "run_sensor",
    "write_readings",
]
