"""Bench: virtual units that deviate from the design, played from image to pose."""

from palpate.bench.bench import FINER, Bench, play_unit, unit_recipe
from palpate.bench.budget import run_budget
from palpate.bench.photograph import Scene, set_scene
from palpate.bench.played import read_played
from palpate.bench.result import describe_bench, run_bench, write_bench
from palpate.bench.simulate import SimulatedSource, draw_touches, simulate_sensor
from palpate.bench.spec import DEGRADED, VirtualBenchSpec
from palpate.bench.write_budget import describe_budget, write_budget
from palpate.built import Deviation, ToleranceSpec

__all__ = [
    "DEGRADED",
    "FINER",
    "Bench",
    "Deviation",
    "Scene",
    "SimulatedSource",
    "ToleranceSpec",
    "VirtualBenchSpec",
    "describe_bench",
    "describe_budget",
    "draw_touches",
    "play_unit",
    "read_played",
    "run_bench",
    "run_budget",
    "set_scene",
    "simulate_sensor",
    "unit_recipe",
    "write_bench",
    "write_budget",
]
