"""Walls of even thickness over a surface, and loads on a point of them.

A wall is one layer of cells (or more) about its middle surface. A force on a point acts on the three nodes through
the wall as an even traction over the thickness would (Simpson's shares); one on the top of a round wall is spread
over the cells around the axis.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray
from palpate.material import Material, NeoHooke
from palpate.mechanics import Solid
from palpate.verify.mapped import Grid, Turn, even, join, map_block, revolve

SHARES = np.array([1.0, 4.0, 1.0]) / 6
"""Of a force on the three nodes through a wall."""
_INCOMPRESSIBLE = 2000.0
"""K / mu where Poisson's ratio is one half: the default of the package."""
_NEAR = 1e-6

Surface = Callable[[FloatArray], FloatArray]
"""From (n, 2) in the unit square to (n, 3)."""


def elastic(young: float, poisson: float) -> Material:
    """Neo-Hooke's law of a Young's modulus and Poisson's ratio at small strain; 0.5 stands for K/mu = 2000."""
    bulk_ratio = _INCOMPRESSIBLE if poisson == 0.5 else 2 * (1 + poisson) / (3 * (1 - 2 * poisson))
    return Material("wall", NeoHooke(young / (4 * (1 + poisson))), bulk_ratio=bulk_ratio)


def wall(middle: Surface, normal: Surface, thickness: float, cells: tuple[int, int]) -> Grid:
    """Mesh a wall of one layer.

    Parameters
    ----------
    middle, normal
        The middle surface and its unit normal.
    thickness
        Its thickness.
    cells
        Along both directions of the unit square.
    """

    def place(q: FloatArray) -> FloatArray:
        return middle(q[:, :2]) + thickness * (q[:, 2:] - 0.5) * normal(q[:, :2])

    return join(map_block((even(cells[0]), even(cells[1]), even(1)), place))


def round_wall(radius: float, thickness: float, cuts: FloatArray, turn: Turn, layers: int = 1) -> Grid:
    """Mesh a quarter of a round cap.

    Parameters
    ----------
    radius, thickness
        Mean radius and thickness.
    cuts
        Polar angles of the cell boundaries, from 0 to the rim, radians.
    turn
        Cells around.
    layers
        Cells through the wall.
    """

    def section(q: FloatArray) -> FloatArray:
        polar, r = cuts[-1] * q[:, 0], radius + thickness * (q[:, 1] - 0.5)
        return np.column_stack([r * np.sin(polar), r * np.cos(polar)])

    return join(revolve(section, (cuts / cuts[-1], even(layers)), turn, solid=True))


def through(grid: Grid, place: FloatArray, normal: FloatArray, thickness: float) -> IntArray:
    """Nodes (3,) through a wall of one layer at a place (3,) of its middle, from inside outward."""
    away = grid.nodes - place
    height = away @ normal
    beside = np.linalg.norm(away - height[:, None] * normal, axis=1)
    on = np.flatnonzero((beside < _NEAR * thickness) & (np.abs(height) < 0.51 * thickness))
    return on[np.argsort(height[on])]


def polar_angle(nodes: FloatArray) -> FloatArray:
    """Angle (n,) of nodes (n, 3) from the z axis, radians."""
    return np.asarray(np.arctan2(np.hypot(nodes[:, 0], nodes[:, 1]), nodes[:, 2]))


def middle_rim(grid: Grid, radius: float, thickness: float, angle: float) -> BoolArray:
    """Nodes (n,) of the middle surface on the rim of a round wall."""
    on = np.abs(np.linalg.norm(grid.nodes, axis=1) - radius) < 1e-3 * thickness
    return on & (np.abs(polar_angle(grid.nodes) - angle) < _NEAR)


def load_top(solid: Solid, angle: float) -> FloatArray:
    """Forces (n, 3) of a quarter of a unit load downward, even over the volume within a polar angle, radians."""
    cells = solid.cells
    inside = (polar_angle(solid.nodes)[cells.nodes] < angle + _NEAR).all(axis=1)
    force = np.zeros_like(solid.nodes)
    np.add.at(force[:, 2], cells.nodes[inside], -np.einsum("eg,ga->ea", cells.weight[inside], solid.shape))
    return force / (4 * np.abs(force[:, 2].sum()))


def press_round(solid: Solid, thickness: float) -> FloatArray:
    """Forces (n, 3) of a unit pressure on the middle of a round wall, along its normal at rest, spread over it."""
    cells = solid.cells
    places = np.einsum("ga,eai->egi", solid.shape, solid.nodes[cells.nodes])
    inward = -places / np.linalg.norm(places, axis=-1, keepdims=True) / thickness
    force = np.zeros_like(solid.nodes)
    np.add.at(force, cells.nodes, np.einsum("eg,ga,egi->eai", cells.weight, solid.shape, inward))
    return force
