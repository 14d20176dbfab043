"""Sensor: a built unit at work: from its images to readings, with what may be wrong about them."""

from palpate.sensor.bench import Bench, Played, play_unit
from palpate.sensor.bench_result import UnitResult, describe_bench, pool_units, run_bench, write_bench
from palpate.sensor.bench_spec import ToleranceSpec, VirtualBenchSpec
from palpate.sensor.budget import BudgetLine, recommend, run_budget
from palpate.sensor.deviation import Deviation, draw_deviation
from palpate.sensor.draw_inspection import draw_inspection
from palpate.sensor.inspect_unit import Inspection, InspectSpec, inspect_unit
from palpate.sensor.photograph import Scene, set_scene
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.register import Registration, register_dome
from palpate.sensor.score import Score, score_readings
from palpate.sensor.sensor import Rest, Sensor, Unit, open_sensor, read_rest, run_sensor
from palpate.sensor.spec import RigSpec
from palpate.sensor.touch import TouchZero, find_zero
from palpate.sensor.write_budget import BUDGET_COLUMNS, budget_row, describe_budget, write_budget
from palpate.sensor.write_readings import describe_reading, write_readings

__all__ = [
    "BUDGET_COLUMNS",
    "Bench",
    "BudgetLine",
    "Deviation",
    "Flag",
    "InspectSpec",
    "Inspection",
    "Played",
    "Reading",
    "Registration",
    "Rest",
    "RigSpec",
    "Scene",
    "Score",
    "Sensor",
    "ToleranceSpec",
    "TouchZero",
    "Unit",
    "UnitResult",
    "VirtualBenchSpec",
    "budget_row",
    "describe_bench",
    "describe_budget",
    "describe_reading",
    "draw_deviation",
    "draw_inspection",
    "find_zero",
    "inspect_unit",
    "open_sensor",
    "play_unit",
    "pool_units",
    "read_rest",
    "recommend",
    "register_dome",
    "run_bench",
    "run_budget",
    "run_sensor",
    "score_readings",
    "set_scene",
    "write_bench",
    "write_budget",
    "write_readings",
]
