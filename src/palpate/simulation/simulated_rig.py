"""Simulated rig for recordings: a simulated unit on a precise robot, in front of a flat wall."""

from __future__ import annotations

import numpy as np

from palpate.calibration import ToleranceSpec, sample_deviation
from palpate.core import generator
from palpate.design import Design
from palpate.sensor import Placement
from palpate.simulation.backend import TwinBackend
from palpate.simulation.simulated_cell import FlatWall, SimulatedCell, seat_unit
from palpate.simulation.simulated_robot import SimulatedRobot
from palpate.simulation.simulated_unit import SimulatedUnit
from palpate.simulation.spec import DEGRADED, SimulatedRobotSpec
from palpate.surrogate import Twin

_RIG = SimulatedRobotSpec(
    position_sd_mm=0.002, rotation_sd_deg=0.01, backlash_mm=0.0, backlash_deg=0.0, compliance=0.0
)
"""Errors of a precise stage; lateral errors of 0.01 mm already shift readings by 0.04°. By hand."""


def simulate_rig(
    twin: Twin, design: Design, tool_length: float = 0.0, seed: int = 0, taken: int = 0
) -> SimulatedCell:
    """Return a unit within the manufacturing tolerances that just touches a flat wall of 1/µ = 1.

    Parameters
    ----------
    twin
        Twin of the design, which gives the marker motion.
    design
        The design.
    tool_length
        Distance from the flange to the middle of the skin's base, mm.
    seed
        Seed of the unit and of all errors.
    taken
        Number of images taken so far, which changes the noise.
    """
    deviation = sample_deviation(ToleranceSpec(), seed, 1)
    rng = generator(seed, "rig", taken)
    axis = np.array([0.0, 0.0, 1.0])
    tool = tool_length * axis
    wall = FlatWall(tool + design.skin.support_point(axis), axis, 1.0)
    backend = TwinBackend(SimulatedUnit(design, deviation, DEGRADED), twin)
    cell = SimulatedCell(backend, wall, Placement(seat_unit(deviation), tool), 0.0, rng)
    cell.robot = SimulatedRobot(Placement(), _RIG, rng, cell.push)
    return cell
