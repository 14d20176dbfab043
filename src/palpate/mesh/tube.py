r"""The grid of a tube: rings of quadrilaterals on the disc with a hole, finer where a press touches.

        .-''''-.
      .'  .--.  '.      hole: the far end's circle; edge: the rim's
     |   |    |   |     cells: along the meridian times around
      '.  '--'  .'
        '-....-'

Cells grow away from the place of contact, around by ``ψ = π (v - A sin(πv)/π)`` with v from 0 there to 1 opposite,
along by the density ``1 + B / cosh²((t - t₀)/W)``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray, IntArray

CELLS, CORE = 24, 3
"""Cells along the meridian, and a quarter of those along half a turn, unless a spec says otherwise."""
_AROUND = 0.6
"""Share A by which cells around are narrower at the contact than the mean, and wider opposite to it."""
_ALONG, _WIDTH = 2.0, 0.15
"""How much denser cells along the meridian are at the contact, B, and how far, W, as a share of its length."""
_TABLE = 4001


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
        Its radius.
    cells, core
        Cells along the meridian, and a quarter of those along half a turn.
    pole
        (2,) place on the disc that is touched, where cells are finest; without one all are alike.
    whole
        The whole disc, or its half x >= 0, touched on its edge x = 0.
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
        angle = np.pi - angle[::-1]  # touched at +y: from -y to +y all the same
    place = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    number = np.arange(place.shape[0] * place.shape[1]).reshape(place.shape[:2])
    columns = np.concatenate([number, number[:, :1]], axis=1) if whole else number
    rows, around = columns.shape
    # the first local axis outward, the second around: counter-clockwise, as cells of the O-grid are
    faces = [columns[i : rows - 2 + i : 2, j : around - 2 + j : 2] for j in range(3) for i in range(3)]
    return TubeGrid(place.reshape(-1, 2), np.stack(faces, -1).reshape(-1, 9), np.concatenate([number[0], number[-1]]))


def _draw_along(share: FloatArray, touched: float) -> FloatArray:
    """Shares (n,) of the meridian, drawn to the place that is touched; both ends stay."""
    t = np.linspace(0, 1, _TABLE)
    count = t + _ALONG * _WIDTH * np.tanh((t - touched) / _WIDTH)
    count = (count - count[0]) / (count[-1] - count[0])
    return np.interp(share, count, t)
