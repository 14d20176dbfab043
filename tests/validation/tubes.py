"""A short cylinder with free ends, pulled apart at two opposite places: bent first, then flat, then stretched.

R = 4.953, L = 10.35, h = 0.094, E = 10.5e6, nu = 0.3125, up to P = 40 000 (consistent units). Reference:
displacements by Abaqus, printed by Sze, Liu & Lo (*Finite Elements in Analysis and Design* 40, 1551, 2004): A is
under the load, B a quarter turn on, C there at the free end. An eighth is solved. B snaps between 0.50 and 0.525 of
the load.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import follow_load
from palpate.verify.read_reference import read_reference
from validation import REFERENCE
from validation.walls import SHARES, elastic, through, wall

_RADIUS, _HALF_LENGTH, _THICKNESS = 4.953, 5.175, 0.094
_YOUNG, _POISSON, _GREATEST = 10.5e6, 0.3125, 40e3
_CELLS = (24, 8)
"""Along a quarter turn and half the length."""
_LOADS = [0.025, 0.1, 0.2, 0.3, 0.4, 0.5, 0.525, 0.6, 0.8, 1.0]
_TOLERANCE = 2e-2


def pulled_cylinder(thicker: float = 1.0) -> list[Row]:
    """Displacements of three places at ten loads; `thicker` is a factor on the thickness, for a control."""
    data = read_reference("pulled_cylinder", REFERENCE).at("load_over_greatest", _LOADS)
    found = pull(_THICKNESS * thicker, data["load_over_greatest"])
    at = [f"P/Pmax = {load:g}" for load in data["load_over_greatest"]]
    columns = ("outward_A", "inward_B", "inward_C")
    return [
        compare(f"displacement, {column.replace('_', ' at ')}", ours, data[column], _TOLERANCE, at)
        for column, ours in zip(columns, found.T, strict=True)
    ]


def pull(thickness: float, loads: FloatArray) -> FloatArray:
    """Displacements (k, 3) of A outward, B and C inward at loads (k,) over the greatest."""

    def normal(q: FloatArray) -> FloatArray:
        angle = 0.5 * np.pi * q[:, 0]
        return np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])

    def middle(q: FloatArray) -> FloatArray:
        return _RADIUS * normal(q) + _HALF_LENGTH * q[:, 1:] * [[0.0, 1.0, 0.0]]

    grid = wall(middle, normal, thickness, _CELLS)
    fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
    x, y, z = np.eye(3)
    pulled = through(grid, _RADIUS * z, z, thickness)
    beside = through(grid, _RADIUS * x, x, thickness)[1]
    end = through(grid, _RADIUS * x + _HALF_LENGTH * y, x, thickness)[1]
    force = np.zeros_like(grid.nodes)
    force[pulled, 2] = 0.25 * _GREATEST * SHARES
    states = follow_load(grid, elastic(_YOUNG, _POISSON), fixed, force, loads)
    return np.array([(s.u[pulled[1], 2], -s.u[beside, 0], -s.u[end, 0]) for s in states])
