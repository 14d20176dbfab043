"""Sensor: a built unit at work: from its images to readings, with what may be wrong about them."""

from palpate.sensor.accept import AcceptSpec, accept_unit
from palpate.sensor.bench import Bench, play_unit
from palpate.sensor.bench_result import describe_bench, run_bench, write_bench
from palpate.sensor.bench_spec import ToleranceSpec, VirtualBenchSpec
from palpate.sensor.budget import run_budget
from palpate.sensor.deviation import Deviation
from palpate.sensor.device import Device
from palpate.sensor.draw_inspection import draw_inspection
from palpate.sensor.inspect_unit import Inspection, InspectSpec, inspect_unit
from palpate.sensor.known_press import KnownPress
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.recording import Truth, read_readings, read_truth
from palpate.sensor.register import Registration, register_dome
from palpate.sensor.score import score_readings
from palpate.sensor.sensor import Rest, Sensor, open_sensor, read_rest, run_sensor
from palpate.sensor.simulate import SimulatedSource
from palpate.sensor.spec import RigSpec
from palpate.sensor.touch import find_zero
from palpate.sensor.unit import Unit
from palpate.sensor.write_acceptance import acceptance_page, write_acceptance
from palpate.sensor.write_budget import describe_budget, write_budget
from palpate.sensor.write_readings import describe_reading, write_readings

__all__ = [
    "AcceptSpec",
    "Bench",
    "Deviation",
    "Device",
    "Flag",
    "InspectSpec",
    "Inspection",
    "KnownPress",
    "Reading",
    "Registration",
    "Rest",
    "RigSpec",
    "Sensor",
    "SimulatedSource",
    "ToleranceSpec",
    "Truth",
    "Unit",
    "VirtualBenchSpec",
    "accept_unit",
    "acceptance_page",
    "describe_bench",
    "describe_budget",
    "describe_reading",
    "draw_inspection",
    "find_zero",
    "inspect_unit",
    "open_sensor",
    "play_unit",
    "read_readings",
    "read_rest",
    "read_truth",
    "register_dome",
    "run_bench",
    "run_budget",
    "run_sensor",
    "score_readings",
    "write_acceptance",
    "write_bench",
    "write_budget",
    "write_readings",
]
