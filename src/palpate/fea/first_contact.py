"""First contact of a skin and an obstacle of any shape that moves along the axis."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from palpate.core import FloatArray, PalpateError
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh

_RINGS, _AROUND = 60, 73
"""Points of the outer surface that start the search, along the meridian and in azimuth. By hand."""
_ROUNDS = 20
"""Maximum number of rounds of the search. By hand."""
_EXACT = 1e-10
"""Penetration at first contact over the base radius. By hand."""


def find_first_contact(mesh: Mesh, obstacle: Obstacle) -> tuple[Obstacle, FloatArray]:
    """Move an obstacle along the axis until it just touches the skin; return it and the contact point.

    Newton's method finds the depth at which the maximum penetration of the surface is zero. Each maximum is found by
    the Nelder-Mead method from the best point of a grid, since the obstacle may not be smooth. The mesh is that of
    the skin; a half one has x >= 0. The obstacle may be at any height.

    Raises
    ------
    PalpateError
        If it misses the skin, or touches its clamped rim first.
    """
    size = mesh.skin.base_radius
    turn = np.pi if not mesh.spec.whole else 2 * np.pi
    angle = np.linspace(0, turn, _AROUND) - np.pi / 2
    radius = np.linspace(0, 1, _RINGS)[:, None]
    disc = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)
    for _ in range(_ROUNDS):
        place, reach = _deepest(mesh, obstacle, disc)
        slope = float(obstacle.gap(place[None]).normal[0, 2])
        if abs(reach) <= _EXACT * size:
            return obstacle, place
        if slope <= 1e-3:
            break
        obstacle = obstacle.moved(np.array([0.0, 0.0, reach / slope]))
    raise PalpateError(
        "The obstacle does not touch the skin when it moves along the axis.",
        "Move it closer to the axis, or make it larger.",
        code="obstacle-misses-skin",
    )


def _deepest(mesh: Mesh, obstacle: Obstacle, disc: FloatArray) -> tuple[FloatArray, float]:
    """Return the point (3,) mm of the outer surface with the maximum penetration, and its penetration, mm."""

    def outside(place: FloatArray) -> FloatArray:
        return mesh.skin.point(place, 1.0, mesh.spec.rim)

    def reach(place: FloatArray) -> float:
        length = max(1.0, float(np.hypot(*place)))
        half = place if mesh.spec.whole else np.array([abs(place[0]), place[1]])
        return -float(obstacle.penetration(outside(half[None] / length))[0])

    start = disc[int(obstacle.penetration(outside(disc)).argmax())]
    found = minimize(reach, start, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-13, "maxiter": 400})
    best = found.x / max(1.0, float(np.hypot(*found.x)))
    if np.hypot(*best) > 1 - 1e-6:
        raise PalpateError(
            "The obstacle touches the clamped rim before the skin.",
            "Move it closer to the axis.",
            code="rim-touched-first",
        )
    if not mesh.spec.whole:
        best[0] = abs(best[0])
    return outside(best[None])[0], -float(found.fun)
