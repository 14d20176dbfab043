r"""The grid of a tube: rings of quadrilaterals on the disc with a hole, finer at the contact.

        .-''''-.
      .'  .--.  '.      hole: the far end's circle; edge: the rim's
     |   |    |   |     cells: along the meridian times in azimuth
      '.  '--'  .'
        '-....-'

Cells grow with the distance from the contact: in azimuth by ``ψ = π (v - A sin(πv)/π)`` with v from 0 there to 1
opposite, along the meridian by the density ``1 + B / cosh²((t - t₀)/W)``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray, IntArray

CELLS, CORE = 24, 3
"""Default cells along the meridian, and a quarter of those along half a turn. By hand."""
_AROUND = 0.6
"""Share A by which cells are narrower in azimuth at the contact than the mean, and wider opposite.
By hand."""
_ALONG, _WIDTH = 2.0, 0.15
"""Additional density B of cells along the meridian at the contact, and its width W over the length.
By hand."""
_TABLE = 4001
"""Points of the table from even to concentrated shares of the meridian. By hand."""


class TubeGrid(NamedTuple):
    """9-node quadrilaterals on the unit disc with a hole, or on its half x >= 0.

    Attributes
    ----------
    points
        (n, 2) nodes.
    cells
        (n_cells, 9) node numbers, lexicographic, counter-clockwise.
    ends
        Numbers of the nodes on the hole's circle and on the edge.
    """

    points: FloatArray
    cells: IntArray
    ends: IntArray


def grid_tube(hole: float, cells: int, core: int, pole: FloatArray | None, *, whole: bool) -> TubeGrid:
    """Grid the unit disc with a hole.

    Parameters
    ----------
    hole
        Radius of the hole.
    cells, core
        Cells along the meridian, and a quarter of those along half a turn.
    pole
        (2,) place of contact on the disc, at the finest cells; without one all are equal.
    whole
        Whether the disc is whole, or its half x >= 0 with the contact on its edge x = 0.
    """
    half = 4 * core
    turn = np.linspace(-1, 1, 4 * half + 1)[:-1] if whole else np.linspace(0, 1, 2 * half + 1)
    along = np.linspace(0, 1, 2 * cells + 1)
    start = -np.pi / 2
    if pole is not None:
        turn = turn - _AROUND * np.sin(np.pi * turn) / np.pi
        along = _draw_along(along, (float(np.hypot(*pole)) - hole) / (1 - hole))
        start = float(np.arctan2(pole[1], pole[0]))
    angle, radius = start + np.pi * turn, hole + (1 - hole) * along
    if not whole and pole is not None and pole[1] > 0:
        angle = np.pi - angle[::-1]  # contact at +y: the order from -y to +y is kept
    place = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    number = np.arange(place.shape[0] * place.shape[1]).reshape(place.shape[:2])
    columns = np.concatenate([number, number[:, :1]], axis=1) if whole else number
    rows, around = columns.shape
    # the first local axis outward, the second around: counter-clockwise, as cells of the O-grid are
    faces = [columns[i : rows - 2 + i : 2, j : around - 2 + j : 2] for j in range(3) for i in range(3)]
    return TubeGrid(place.reshape(-1, 2), np.stack(faces, -1).reshape(-1, 9), np.concatenate([number[0], number[-1]]))


def _draw_along(share: FloatArray, touched: float) -> FloatArray:
    """Return shares (n,) of the meridian, concentrated at the contact; both ends are unchanged."""
    t = np.linspace(0, 1, _TABLE)
    count = t + _ALONG * _WIDTH * np.tanh((t - touched) / _WIDTH)
    count = (count - count[0]) / (count[-1] - count[0])
    return np.interp(share, count, t)
