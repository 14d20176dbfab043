"""An O-grid on the unit disc: a convex square core inside rings of quadrilaterals.

The mesh of a dome is this grid mapped to the sphere: radius on the disc becomes polar angle (equal steps along the
meridian), azimuth is unchanged. ::

        .-''''-.
      .'\\______/'.      core: 2m x 2m cells
     /  |      |  \\     rings: n of them, 8m cells each
     \\  |______|  /
      './      \\.'
        '-....-'
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, IntArray

_BULGE = 0.25
"""Share of the square-to-ellipse map in the core; ½ would make the core a disc with flat corners."""


@dataclass(frozen=True)
class DiscGrid:
    """9-node quadrilaterals on the unit disc, or on its half x >= 0.

    Attributes
    ----------
    points
        (n, 2) nodes.
    cells
        (n_cells, 9) node numbers, lexicographic, counter-clockwise.
    core
        (rows, columns) node numbers of the core, rows along y, columns along x.
    sides
        (rows, columns) node numbers of the rings next to each side of the core, rows along it, columns outward; the
        sides are +x, +y, -x, -y, the third only for a whole disc.
    """

    points: FloatArray
    cells: IntArray
    core: IntArray
    sides: tuple[IntArray, ...]


def grid_disc(core: int, rings: int, *, whole: bool) -> DiscGrid:
    """Grid the unit disc, whole or its half x >= 0 (the skin's mirror plane is x = 0).

    The core has ``2 core`` by ``2 core`` cells; `rings` lie between core and circle.
    """
    size = core / (core + rings)
    patches = [_core_patch(core, size, whole)]
    quarter = np.linspace(-1, 1, 4 * core + 1)
    sides = (
        {0: quarter, 1: quarter, 2: quarter, 3: quarter}
        if whole
        else {
            0: quarter,
            1: quarter[: 2 * core + 1],
            3: quarter[2 * core :],
        }
    )
    patches += [_ring_patch(side, along, rings, size) for side, along in sides.items()]
    return _join(patches)


def _core_point(a: FloatArray, b: FloatArray, size: float) -> FloatArray:
    x, y = np.tan(a * np.pi / 4), np.tan(b * np.pi / 4)
    return size * np.stack([x * np.sqrt(1 - _BULGE * y * y), y * np.sqrt(1 - _BULGE * x * x)], axis=-1)


def _core_patch(core: int, size: float, whole: bool) -> FloatArray:
    b = np.linspace(-1, 1, 4 * core + 1)
    a = b if whole else np.linspace(0, 1, 2 * core + 1)
    return _core_point(a[None, :], b[:, None], size)


def _ring_patch(side: int, along: FloatArray, rings: int, size: float) -> FloatArray:
    """Return the rings at one side of the core: rows along it, columns outward; side 0 is at +x, 1 at +y."""
    inner = _core_point(np.ones_like(along), along, size)
    angle = along * np.pi / 4
    outer = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    t = np.linspace(0, 1, 2 * rings + 1)[None, :, None]
    points = (1 - t) * inner[:, None] + t * outer[:, None]
    cos, sin = [(1, 0), (0, 1), (-1, 0), (0, -1)][side]
    return np.stack([cos * points[..., 0] - sin * points[..., 1], sin * points[..., 0] + cos * points[..., 1]], -1)


def _join(patches: list[FloatArray]) -> DiscGrid:
    points, cells, start = [], [], 0
    blocks: list[IntArray] = []
    number: IntArray
    for patch in patches:
        rows, columns = patch.shape[:2]
        number = start + np.arange(rows * columns).reshape(rows, columns)
        faces = [number[j : rows - 2 + j : 2, i : columns - 2 + i : 2] for j in range(3) for i in range(3)]
        cells.append(np.stack(faces, -1).reshape(-1, 9))
        blocks.append(number)
        points.append(patch.reshape(-1, 2))
        start += rows * columns
    every = np.concatenate(points)
    _, first, merged = np.unique(np.round(every, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    number = merged.ravel()
    named = [number[block] for block in blocks]
    return DiscGrid(every[first], number[np.concatenate(cells)], named[0], tuple(named[1:]))
