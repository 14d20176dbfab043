"""Mechanics of a simulated unit, by the twin of its design or by presses solved for it.

The twin takes a millisecond, so that whole studies can be simulated, but it is also the model of the estimator.
Solved presses are independent of it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property
from typing import final

import numpy as np
from scipy.signal import resample

from palpate.core import FloatArray
from palpate.core.state import State
from palpate.design import TILT_SPACE, turn_about_axis
from palpate.fea import Branch, Press, WallSpec, solve_press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.simulation.simulated_unit import SimulatedUnit
from palpate.surrogate import LATERAL, MarkerState, MarkerTwin, Twin, interpolate_depths

_CARRIED = 8
"""Number of edge points that the twin moves; the edge is their trigonometric polynomial.

On the dome of tests/small_chain.py the edge error is 0.011 mm with 4 points, 0.001 mm with 8 and 0.0007 mm with 16.
"""
_STEP_MM = 0.25
"""Depth step of solved presses, mm. By hand."""
_ABOUT = 4
"""Number of increments of a cubic interpolation by depth. By hand."""


class UnitBackend(ABC):
    """Mechanics of one simulated unit.

    Parameters
    ----------
    unit
        The unit.
    """

    def __init__(self, unit: SimulatedUnit) -> None:
        self.unit = unit

    @abstractmethod
    def edges(self, contact: State, inverted: bool = False) -> FloatArray:
        """Edges (m, k, 3) mm of the markers at a contact (`palpate.calibration.CONTACT_STATE`)."""

    @abstractmethod
    def force(self, contact: State, inverted: bool = False) -> FloatArray:
        """Force (3,) N on the wall, in the frame of the sensor."""


@final
class TwinBackend(UnitBackend):
    """A unit by the twin of its design, with its thickness and stiffness, without its stiffening.

    Parameters
    ----------
    unit
        The unit.
    twin
        Twin of its design.
    """

    def __init__(self, unit: SimulatedUnit, twin: Twin) -> None:
        super().__init__(unit)
        self._twins = (twin,) if twin.inverted is None else (twin, twin.inverted)

    @cached_property
    def _carried(self) -> FloatArray:
        return self.unit.edges[:, :: self.unit.edges.shape[1] // _CARRIED]

    @cached_property
    def rest_edges(self) -> FloatArray:
        """Edges (m, k, 3) mm of the markers at rest, through the points that the twin moves."""
        return resample_edges(self._carried, self.unit.edges.shape[1])

    @cached_property
    def _dots(self) -> tuple[MarkerTwin, ...]:
        return tuple(twin.with_markers(self._carried.reshape(-1, 3)) for twin in self._twins)

    @cached_property
    def _points(self) -> tuple[MarkerTwin, ...]:
        """Single point, for the force."""
        return tuple(twin.with_markers(self._carried[0, :1]) for twin in self._twins)

    def edges(self, contact: State, inverted: bool = False) -> FloatArray:
        moved = self._evaluate(self._dots[inverted], contact)
        return resample_edges(moved.positions.reshape(self._carried.shape), self.unit.edges.shape[1])

    def force(self, contact: State, inverted: bool = False) -> FloatArray:
        return (1.0 + self.unit.deviation.modulus) * self._evaluate(self._points[inverted], contact).force

    def _evaluate(self, dots: MarkerTwin, contact: State) -> MarkerState:
        motion, thickness = contact[LATERAL], self.unit.deviation.thickness
        return dots.evaluate(
            contact[TILT_SPACE.names],
            contact["inverse_friction"],
            thickness,
            motion if motion.any() else None,
            contact["curvature"],
        )


@final
class SolverBackend(UnitBackend):
    """A unit by presses solved for every tilt and friction.

    Parameters
    ----------
    unit
        The unit.
    depth
        Maximum depth of a press, mm.
    cells
        Cells of the mesh along a meridian; `None`: the skin's default.
    """

    def __init__(self, unit: SimulatedUnit, depth: float, cells: int | None = None) -> None:
        super().__init__(unit)
        self._depth, self._cells = depth, cells
        self._solved: dict[tuple[float, float, bool], Press] = {}

    def edges(self, contact: State, inverted: bool = False) -> FloatArray:
        press, depth = self._press(contact, inverted)
        azimuth_deg = float(np.degrees(np.arctan2(contact["ry_deg"], contact["rx_deg"])))
        turned = replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": azimuth_deg}))
        return self.unit.press_edges(turned, depth)[0]

    def force(self, contact: State, inverted: bool = False) -> FloatArray:
        if contact["depth_mm"] <= 0.0:
            return np.zeros(3)
        press, depth = self._press(contact, inverted)
        azimuth = float(np.arctan2(contact["ry_deg"], contact["rx_deg"]))
        return turn_about_axis(azimuth) @ interpolate_depths(press, press.force, depth)[0]  # solved at azimuth 0

    def _press(self, contact: State, inverted: bool) -> tuple[Press, FloatArray]:
        """Increments of a press about a depth, and the depth (1,) mm, no deeper than the press."""
        tilt_deg, slip = (
            round(float(np.hypot(contact["rx_deg"], contact["ry_deg"])), 3),
            round(contact["inverse_friction"], 6),
        )
        if (tilt_deg, slip, inverted) not in self._solved:
            friction = 1.0 / slip if slip > 0 else "no-slip"
            wall = WallSpec(tilt_deg=tilt_deg, depth=self._depth, depth_step=_STEP_MM, contact=friction)
            built = self.unit.deviation.built(self.unit.design)
            mesh = mesh_skin(built.skin, MeshSpec(cells=self._cells, filled=built.material.has_gel))
            branch = Branch.INVERTED if inverted else Branch.FLAT
            self._solved[tilt_deg, slip, inverted] = solve_press(mesh, built.material, wall, branch=branch)
        press = self._solved[tilt_deg, slip, inverted]
        depth = np.minimum(contact[("depth_mm",)], press.depth[-1])
        after = int(np.searchsorted(press.depth, depth[0]))
        first = int(np.clip(after - _ABOUT // 2, 0, max(len(press.depth) - _ABOUT, 0)))
        return press.cut(first, first + _ABOUT), depth


def resample_edges(points: FloatArray, corners: int) -> FloatArray:
    """Edges (m, corners, 3) by the trigonometric polynomial through points (m, k, 3)."""
    return np.asarray(np.moveaxis(resample(np.moveaxis(points, 1, -1), corners, axis=-1), -1, 1), float)
