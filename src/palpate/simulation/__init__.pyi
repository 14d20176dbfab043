"""Simulation: manufactured units, their images and forces by a twin or solved presses, and trials."""

from palpate.calibration import Deviation, ToleranceSpec
from palpate.simulation.alignment_trial import (
    AlignmentScenario,
    AlignmentTrial,
    VirtualUnit,
    describe_wall,
    list_wall_touches,
    write_alignments,
)
from palpate.simulation.backend import SolverBackend, TwinBackend, UnitBackend
from palpate.simulation.budget import run_budget
from palpate.simulation.result import bench_summary, describe_bench, run_bench, write_bench
from palpate.simulation.run_trial import FINER, VirtualBench, run_unit_trial, unit_recipe
from palpate.simulation.simulated_rig import simulate_rig
from palpate.simulation.simulated_robot import SimulatedRobot
from palpate.simulation.simulated_source import SimulatedSource, sample_presses, simulate_sensor
from palpate.simulation.simulated_unit import SimulatedUnit
from palpate.simulation.spec import DEGRADED, SimulatedRobotSpec, VirtualBenchSpec, WorkpieceSpec
from palpate.simulation.trial import read_trial
from palpate.simulation.write_budget import describe_budget, write_budget

__all__ = [
    "DEGRADED",
    "FINER",
    "AlignmentScenario",
    "AlignmentTrial",
    "Deviation",
    "SimulatedRobot",
    "SimulatedRobotSpec",
    "SimulatedSource",
    "SimulatedUnit",
    "SolverBackend",
    "ToleranceSpec",
    "TwinBackend",
    "UnitBackend",
    "VirtualBench",
    "VirtualBenchSpec",
    "VirtualUnit",
    "WorkpieceSpec",
    "bench_summary",
    "describe_bench",
    "describe_budget",
    "describe_wall",
    "list_wall_touches",
    "read_trial",
    "run_bench",
    "run_budget",
    "run_unit_trial",
    "sample_presses",
    "simulate_rig",
    "simulate_sensor",
    "unit_recipe",
    "write_alignments",
    "write_bench",
    "write_budget",
]
