"""Bench: virtual units that deviate from the design, played from image to pose."""

from palpate.bench.bench import FINER, VirtualBench, run_unit_trial, unit_recipe
from palpate.bench.budget import run_budget
from palpate.bench.photograph import Scene, build_scene
from palpate.bench.played import read_trial
from palpate.bench.result import bench_summary, describe_bench, run_bench, write_bench
from palpate.bench.simulate import SimulatedSource, sample_presses, simulate_sensor
from palpate.bench.spec import DEGRADED, VirtualBenchSpec
from palpate.bench.write_budget import describe_budget, write_budget
from palpate.built import Deviation, ToleranceSpec

__all__ = [
    "DEGRADED",
    "FINER",
    "Deviation",
    "Scene",
    "SimulatedSource",
    "ToleranceSpec",
    "VirtualBench",
    "VirtualBenchSpec",
    "bench_summary",
    "build_scene",
    "describe_bench",
    "describe_budget",
    "read_trial",
    "run_bench",
    "run_budget",
    "run_unit_trial",
    "sample_presses",
    "simulate_sensor",
    "unit_recipe",
    "write_bench",
    "write_budget",
]
