"""A shallow cylindrical roof on hinges under a force at its middle: it snaps through, and a thin one snaps back.

R = 2540, half its span 0.1 rad, half its length 254, thickness 12.7 or 6.35, E = 3102.75, nu = 0.3 (consistent
units). The straight edges are hinged, the curved ones free (Sabir & Lock 1972). Reference: load against the
deflection under it by Abaqus, printed by Sze, Liu & Lo (*Finite Elements in Analysis and Design* 40, 1551, 2004).
A quarter is solved, hinged on the line in the middle of its wall.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.mechanics import Problem, make_linear_solver
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import make_solid
from palpate.verify.read_reference import read_reference
from validation import REFERENCE
from validation.arc_length import ArcLength
from validation.curves import away_from, turns
from validation.walls import SHARES, elastic, through, wall

THICKNESSES = (12.7, 6.35)
_RADIUS, _HALF_LENGTH, _HALF_ANGLE = 2540.0, 254.0, 0.1
_YOUNG, _POISSON, _GREATEST = 3102.75, 0.3, 3000.0
"""The last is the load that the table is in units of."""
_CELLS = 10
"""Along half the span and half the length."""
_FIRST, _LONGEST = 0.127, 0.508
"""Increments of the path."""
_TOLERANCE, _RESIDUAL = 2e-2, 1e-6


def hinged_roof(thickness: float, thicker: float = 1.0) -> list[Row]:
    """The whole path and both limit loads of a roof.

    Parameters
    ----------
    thickness
        12.7 or 6.35.
    thicker
        Factor on the thickness of ours; 1 but for a control that must not pass.
    """
    data = read_reference("hinged_roofs", REFERENCE).where(thickness=f"{thickness:g}")
    theirs = np.column_stack([data["deflection"], data["load_over_greatest"]])
    curve = follow_roof(thickness * thicker, float(theirs[:, 0].max()))
    away = away_from(curve, theirs)
    at = [f"w = {deflection:g}" for deflection in theirs[:, 0]]
    upper, lower = turns(curve)
    load = theirs[:, 1]
    peak = int(np.argmax(np.diff(load) < 0))
    valley = float(load[peak:].min())
    return [
        compare("distance from the path, over deflection and load at most", away, 0 * away, _TOLERANCE, at, 1.0),
        compare("upper limit load, over 3000", upper, load[peak], _TOLERANCE),
        compare("lower limit load, over 3000; of the upper", lower, valley, _TOLERANCE, (), load[peak]),
    ]


def follow_roof(thickness: float, deflection: float) -> FloatArray:
    """Deflection under the load and load over 3000 (k, 2) along the path, to a deflection."""

    def normal(q: FloatArray) -> FloatArray:
        angle = _HALF_ANGLE * q[:, 0]
        return np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])

    def middle(q: FloatArray) -> FloatArray:
        return _RADIUS * normal(q) + _HALF_LENGTH * q[:, 1:] * [[0.0, 1.0, 0.0]]

    grid = wall(middle, normal, thickness, (_CELLS, _CELLS))
    nodes = grid.nodes
    angle, away = np.arctan2(nodes[:, 0], nodes[:, 2]), np.hypot(nodes[:, 0], nodes[:, 2]) - _RADIUS
    hinge = (np.abs(angle - _HALF_ANGLE) < 1e-9) & (np.abs(away) < 1e-3 * thickness)
    fixed = np.stack([grid.near(0, 0.0) | hinge, grid.near(1, 0.0) | hinge, hinge], axis=-1)
    solid = make_solid(grid, elastic(_YOUNG, _POISSON), fixed)
    under = through(grid, np.array([0.0, 0.0, _RADIUS]), np.array([0.0, 0.0, 1.0]), thickness)
    force = np.zeros_like(nodes)
    force[under, 2] = -0.25 * _GREATEST * SHARES
    problem = Problem(solid, make_linear_solver(), _RESIDUAL * _GREATEST / 4, thickness)
    path = ArcLength(problem, force, _FIRST, _LONGEST)
    while -path.points[-1].state.u[under[1], 2] < deflection:
        path.advance()
    return np.array([(-point.state.u[under[1], 2], point.factor) for point in path.points])
