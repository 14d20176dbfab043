"""Structured meshes of 27-node hexahedra for bodies of known solution: mapped blocks, joined.

A block is a unit cube cut into cells and mapped to the body by a function; coincident nodes are joined. Bodies of
revolution are made from maps of their meridian section: an O-grid around the axis, rings further out. Nodes of a cell
are numbered as in `palpate.mesh`: the first local axis fastest, the third one outward.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray

Map = Callable[[FloatArray], FloatArray]
"""Map of points (n, 3) of the unit cube, or (n, 2) of the unit square, to points in mm."""

_CORE = 0.5
"""Half side of the square in the middle of an O-grid over the radius of its circle. By hand."""
_JOIN = 1e-7
"""Distance over the body's size within which nodes are one. By hand."""
_OUTER_FACE = np.arange(18, 27)
_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Grid:
    """Nodes and cells of a body.

    Attributes
    ----------
    nodes
        (n, 3) mm.
    cells
        (n_cells, 27) node numbers.
    """

    nodes: FloatArray
    cells: IntArray

    def outer_cells(self, on: BoolArray) -> IntArray:
        """Cells (k,) whose face zeta = +1 lies wholly on the nodes marked in `on` (n,)."""
        return np.flatnonzero(on[self.cells[:, _OUTER_FACE]].all(axis=1))

    def outer_faces(self, cells: IntArray) -> IntArray:
        """Faces zeta = +1 (k, 9) of cells (k,)."""
        return self.cells[cells][:, _OUTER_FACE]

    def near(self, axis: int, value: float) -> BoolArray:
        """Nodes (n,) whose coordinate along an axis is `value`, mm."""
        return np.abs(self.nodes[:, axis] - value) < _JOIN * np.ptp(self.nodes)


def even(count: int, power: float = 1.0) -> FloatArray:
    """Cut 0…1 into `count` cells (count + 1,), finer towards 0 for a power above 1."""
    return np.linspace(0.0, 1.0, count + 1) ** power


def map_block(cuts: tuple[FloatArray, FloatArray, FloatArray], place: Map) -> FloatArray:
    """Map a unit cube, cut along its axes, to a body.

    Parameters
    ----------
    cuts
        Cell boundaries in 0…1 along each axis.
    place
        Map of the unit cube to mm.

    Returns
    -------
    (n_cells, 27, 3)
        Positions of the nodes of every cell, mm.
    """
    lines = [np.stack([cut[:-1], 0.5 * (cut[:-1] + cut[1:]), cut[1:]], axis=-1) for cut in cuts]
    shape = [len(line) for line in lines]
    points = np.empty((*shape, 3, 3, 3, 3))
    points[..., 0] = lines[0][:, None, None, None, None, :]
    points[..., 1] = lines[1][None, :, None, None, :, None]
    points[..., 2] = lines[2][None, None, :, :, None, None]
    return place(points.reshape(-1, 3)).reshape(-1, 27, 3)


def join(*blocks: FloatArray) -> Grid:
    """Join blocks (n_cells, 27, 3) mm: nodes at one place become one."""
    positions = np.concatenate(blocks)
    flat = positions.reshape(-1, 3)
    keys = np.round(flat / (_JOIN * np.ptp(flat)) + 1 / np.pi).astype(np.int64)
    _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return Grid(flat[first], number.reshape(len(positions), 27))


@dataclass(frozen=True)
class Turn:
    """Revolution of a section about the z axis.

    Attributes
    ----------
    cells
        Cells in an eighth of a turn.
    quarters
        Quarters of a turn, from the plane y = 0: 1 or 4.
    """

    cells: int = 1
    quarters: int = 1


def revolve(section: Map, cuts: tuple[FloatArray, FloatArray], turn: Turn, *, solid: bool) -> FloatArray:
    """Revolve a section about the z axis.

    Parameters
    ----------
    section
        Map of (xi, eta) of the unit square to (r, z) in mm; xi leads away from the axis, eta to the outer face.
    cuts
        Cell boundaries of xi and eta.
    turn
        Cells around, and angle.
    solid
        Whether xi = 0 is the axis, to be filled by an O-grid as wide as the first cell.

    Returns
    -------
    (n_cells, 27, 3)
        Positions of the nodes, mm.
    """
    xi, eta = cuts
    around = np.linspace(0.0, 1.0, 2 * turn.cells + 1)

    def ring(q: FloatArray) -> FloatArray:
        return _turned(section(q[:, [0, 2]]), 0.5 * np.pi * q[:, 1])

    def disc(plan: Map) -> Map:
        def place(q: FloatArray) -> FloatArray:
            x, y = plan(q[:, :2]).T
            return _turned(section(np.column_stack([xi[1] * np.hypot(x, y), q[:, 2]])), np.arctan2(y, x))

        return place

    blocks = []
    if solid:
        half, ends = even(turn.cells), np.array([0.0, 1.0])
        blocks.append(map_block((half, half, eta), disc(lambda q: _CORE * q)))
        blocks.append(map_block((ends, half, eta), disc(_first_side)))
        blocks.append(map_block((ends, half, eta), disc(_second_side)))
    rings = xi[1:] if solid else xi
    if len(rings) > 1:
        blocks.append(map_block((rings, around, eta), ring))
    quarters = [np.concatenate(blocks)]
    for _ in range(turn.quarters - 1):
        quarters.append(quarters[-1] @ _QUARTER_TURN.T)
    return np.concatenate(quarters)


def _turned(section: FloatArray, azimuth: FloatArray) -> FloatArray:
    r, z = section.T
    return np.column_stack([r * np.cos(azimuth), r * np.sin(azimuth), z])


def _first_side(q: FloatArray) -> FloatArray:
    """Map the region from the side x = const of the core to the circle, azimuth 0…45°."""
    t, angle = q[:, :1], 0.25 * np.pi * q[:, 1]
    inner = _CORE * np.column_stack([np.ones_like(angle), q[:, 1]])
    return (1 - t) * inner + t * np.column_stack([np.cos(angle), np.sin(angle)])


def _second_side(q: FloatArray) -> FloatArray:
    """Map the region from the side y = const of the core to the circle, azimuth 45…90°."""
    t, angle = q[:, :1], 0.25 * np.pi * (1 + q[:, 1])
    inner = _CORE * np.column_stack([1 - q[:, 1], np.ones_like(angle)])
    return (1 - t) * inner + t * np.column_stack([np.cos(angle), np.sin(angle)])
