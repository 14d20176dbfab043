"""A built unit's dome under a wall: where the edges of its dots are and what the wall bears, twice over.

By the twin, which takes a millisecond, so that whole studies can be played, and which shares the idea of what reads;
and by presses that are solved for each touch, which does not.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from palpate.built import Deviation
from palpate.core import FloatArray
from palpate.design import Design, wall_normal
from palpate.fea import Press, WallSpec, solve_press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.twin import MarkerTwin, Twin, interpolate_depths

_STEP_MM = 0.25
"""Depth step of the presses."""
_ABOUT = 4
"""Increments about a depth, through which a cubic is laid."""


class ContactBackend(ABC):
    """A dome under a wall."""

    @abstractmethod
    def marker_outlines(self, pose: FloatArray, inverse_friction: float, lateral: FloatArray) -> FloatArray:
        """Edges (m, k, 3) mm of the dots.

        At rx, ry (degrees) and depth (mm), under 1/µ = `inverse_friction`; `lateral` (3,) is how far the wall has
        travelled in its plane (mm) and turned (degrees) since first touch.
        """

    @abstractmethod
    def force(self, pose: FloatArray, inverse_friction: float) -> FloatArray:
        """Force (3,) N on the wall, dome's frame."""


@final
class TwinBackend(ContactBackend):
    """A unit's dome as the twin of its design has it.

    Parameters
    ----------
    twin
        Of the design.
    rest
        (m, k, 3) mm, edges of the unit's dots.
    deviation
        The unit; its thickness and stiffness count, its stiffening does not.
    """

    def __init__(self, twin: Twin, rest: FloatArray, deviation: Deviation) -> None:
        self._shape, self._deviation = rest.shape, deviation
        self._edges: MarkerTwin = twin.with_markers(rest.reshape(-1, 3))
        self._one: MarkerTwin = twin.with_markers(rest[0, :1])

    def marker_outlines(self, pose: FloatArray, inverse_friction: float, lateral: FloatArray) -> FloatArray:
        moved = self._edges.evaluate(pose, inverse_friction, self._deviation.thickness, lateral)
        return moved.positions.reshape(self._shape)

    def force(self, pose: FloatArray, inverse_friction: float) -> FloatArray:
        stiff = 1.0 + self._deviation.modulus
        return stiff * self._one.evaluate(pose, inverse_friction, self._deviation.thickness).force


@final
@dataclass(eq=False)
class SolverBackend(ContactBackend):
    """A unit's dome by presses that are solved for every tilt and friction it meets; drift is left out.

    Attributes
    ----------
    built
        The unit as built.
    rest
        (m, k, 3) mm, edges of its dots.
    depth
        To which it can be pressed, mm.
    cells
        Of the mesh, along a meridian; `None`: its own number.
    """

    built: Design
    rest: FloatArray
    depth: float
    cells: int | None = None
    _solved: dict[tuple[float, float], Press] = field(default_factory=dict)

    def marker_outlines(self, pose: FloatArray, inverse_friction: float, lateral: FloatArray) -> FloatArray:
        press, depth = self._press(pose, inverse_friction)
        azimuth_deg = float(np.degrees(np.arctan2(pose[1], pose[0])))
        turned = replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": azimuth_deg}))
        return interpolate_depths(press, turned.positions(self.rest.reshape(-1, 3)), depth).reshape(self.rest.shape)

    def force(self, pose: FloatArray, inverse_friction: float) -> FloatArray:
        if pose[2] <= 0.0:
            return np.zeros(3)
        press, depth = self._press(pose, inverse_friction)
        pressing = press.force @ wall_normal(np.radians(press.obstacle.radial), 0.0)
        return interpolate_depths(press, pressing, depth) * wall_normal(*np.radians(pose[:2]))

    def _press(self, pose: FloatArray, inverse_friction: float) -> tuple[Press, FloatArray]:
        """Increments of a press about a pose, and the depth (1,) mm, no deeper than the press."""
        key = round(float(np.hypot(*pose[:2])), 3), round(inverse_friction, 6)
        if key not in self._solved:
            contact = 1.0 / inverse_friction if inverse_friction > 0 else "no-slip"
            wall = WallSpec(tilt_deg=key[0], depth=self.depth, depth_step=_STEP_MM, contact=contact)
            spec = MeshSpec(cells=self.cells, filled=self.built.material.has_gel)
            self._solved[key] = solve_press(mesh_skin(self.built.skin, spec), self.built.material, wall)
        press = self._solved[key]
        depth = np.minimum(pose[2:], press.depth[-1])
        first = int(
            np.clip(np.searchsorted(press.depth, depth[0]) - _ABOUT // 2, 0, max(len(press.depth) - _ABOUT, 0))
        )
        return press.cut(first, first + _ABOUT), depth
