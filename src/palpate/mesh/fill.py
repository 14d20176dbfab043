r"""Mesh of the filling of a skin: shells of cells next to the skin, and a block in the middle.

         .-'''''-.           skin
       .' _______ '.
      /  /   |   \  \        shells: offset inward from the skin's inner surface
     |--|----|----|--|
     |  |    |    |  |       block: a box of cells, its top under the core of the grid, its sides under the rings
     |__|____|____|__|       base plane z = 0, bonded to the window

The block is interpolated between its six faces by transfinite interpolation (Gordon & Hall 1973).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray, IntArray
from palpate.mesh.disc import DiscGrid

SHELLS = 3
"""Number of cells between the skin and the block. By hand."""
_SIZE, _BOX = 0.5, 0.6
"""Size of the block over that of the hollow, and weight of a box shape against that of the hollow.
By hand."""


class Filling(NamedTuple):
    """Mesh of the filling of a skin.

    Attributes
    ----------
    nodes
        (n, 3) mm, additional nodes, numbered after those of the skin.
    cells
        (n_cells, 27) node numbers.
    base
        Additional nodes on the base plane.
    """

    nodes: FloatArray
    cells: IntArray
    base: IntArray


def mesh_filling(grid: DiscGrid, inner: FloatArray, first: int, *, whole: bool) -> Filling:
    """Mesh the hollow under a grid.

    Parameters
    ----------
    grid
        Grid of the skin's surfaces.
    inner
        (n, 3) mm, its nodes on the inner surface; they are the first of the mesh.
    first
        Number of the first additional node.
    whole
        Whether the skin is whole, or its half x >= 0.
    """
    outer = _block_surface(grid, inner, whole)
    steps = 2 * SHELLS
    share = (np.arange(1, steps + 1) / steps)[:, None, None]
    shells = inner + share * (outer - inner)
    n = len(inner)
    layer = np.concatenate([np.arange(n)[None], first + np.arange(steps * n).reshape(steps, n)])
    shell_cells = [np.concatenate([layer[2 * k + j][grid.cells] for j in (2, 1, 0)], axis=1) for k in range(SHELLS)]
    number, inside = _block(grid, outer, layer[-1], first + steps * n, whole)
    nodes = np.concatenate([shells.reshape(-1, 3), inside])
    cells = np.concatenate([*shell_cells, _cells(number)])
    return Filling(nodes, cells, first + np.flatnonzero(np.abs(nodes[:, 2]) < 1e-9 * inner[:, 2].max()))


def _block_surface(grid: DiscGrid, inner: FloatArray, whole: bool) -> FloatArray:
    """Return the positions of the grid's nodes (n, 3) mm on the block: between a box and a smaller hollow."""
    cube = np.empty((len(inner), 3))
    rows, columns = grid.core.shape
    y, x = np.linspace(-1, 1, rows), np.linspace(-1 if whole else 0, 1, columns)
    cube[grid.core] = np.stack([*np.meshgrid(x, y), np.ones((rows, columns))], -1)
    turns = [(1, 0), (0, 1), (-1, 0), (0, -1)] if whole else [(1, 0), (0, 1), (0, -1)]
    for (cos, sin), side in zip(turns, grid.sides, strict=True):
        along, height = np.linspace(-1, 1, rows), np.linspace(1, 0, side.shape[1])
        if len(side) < rows:  # half a side of a half disc
            along = along[: len(side)] if sin > 0 else along[-len(side) :]
        t, z = np.meshgrid(along, height, indexing="ij")
        cube[side] = np.stack([cos - sin * t, sin + cos * t, z], -1)
    size = np.array([*[np.hypot(inner[:, 0], inner[:, 1]).max()] * 2, inner[:, 2].max()]) / np.sqrt(2.0)
    surface = _SIZE * (_BOX * cube * size + (1 - _BOX) * inner)
    surface[cube[:, 2] == 0, 2] = 0.0
    if not whole:
        surface[cube[:, 0] == 0, 0] = 0.0
    return surface


def _block(
    grid: DiscGrid, outer: FloatArray, numbers: IntArray, first: int, whole: bool
) -> tuple[IntArray, FloatArray]:
    """Return node numbers (x, y, z) of the block's lattice, and its nodes (n, 3) mm not on the shells."""
    columns, rows = grid.core.shape[::-1]
    deep = grid.sides[0].shape[1]
    known = np.full((columns, rows, deep), -1, np.int64)
    known[:, :, -1] = grid.core.T
    plus_x, plus_y, *rest = grid.sides
    minus_y = rest[-1]
    known[-1] = plus_x[:, ::-1]
    known[:, -1] = plus_y[::-1, ::-1]
    known[:, 0] = minus_y[:, ::-1]
    if whole:
        known[0] = rest[0][::-1, ::-1]
    place = np.where(known[..., None] >= 0, outer[known], np.nan)
    if not whole:
        place[0, :, 0] = _between(place[0, :, 0], 0)
    _span_face(place, (slice(None), slice(None), 0))
    if not whole:
        _span_face(place, (0, slice(None), slice(None)))
    _span(place)
    number = np.where(known >= 0, numbers[known], -1)
    free = np.flatnonzero(number.ravel() < 0)
    number.ravel()[free] = first + np.arange(len(free))
    return number, place.reshape(-1, 3)[free]


def _between(values: FloatArray, axis: int) -> FloatArray:
    """Interpolate linearly along an axis between the first and the last of the values."""
    count = values.shape[axis]
    share = np.linspace(0, 1, count).reshape([-1 if k == axis else 1 for k in range(values.ndim)])
    first, last = np.take(values, [0], axis), np.take(values, [-1], axis)
    return np.asarray((1 - share) * first + share * last)


def _span_face(place: FloatArray, face: tuple[slice | int, ...]) -> None:
    """Fill a face of the lattice from its four edges (Coons)."""
    values = place[face]
    along, across = _between(values, 0), _between(values, 1)
    inside = (along + across - _between(across, 0))[1:-1, 1:-1]
    values[1:-1, 1:-1] = inside


def _span(place: FloatArray) -> None:
    """Fill the lattice (x, y, z, 3) from its six faces."""
    x, y, z = (_between(place, axis) for axis in range(3))
    xy, yz, zx = _between(y, 0), _between(z, 1), _between(x, 2)
    inside = x + y + z - xy - yz - zx + _between(yz, 0)
    place[1:-1, 1:-1, 1:-1] = inside[1:-1, 1:-1, 1:-1]


def _cells(number: IntArray) -> IntArray:
    """Return the cells (n, 27) of a lattice (x, y, z) of node numbers."""
    i, j, k = (np.arange(0, count - 2, 2) for count in number.shape)
    corner = np.stack([axis.ravel() for axis in np.meshgrid(i, j, k, indexing="ij")], -1)
    steps = [(a, b, c) for c in range(3) for b in range(3) for a in range(3)]
    return np.stack([number[tuple((corner + step).T)] for step in steps], -1)
