"""Where an obstacle of any shape that comes down along the axis first touches a skin."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from palpate.core import FloatArray, PalpateError
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh

_RINGS, _AROUND = 60, 73
_ROUNDS = 20
_EXACT = 1e-10
"""Penetration at first touch over the base radius."""


def find_first_contact(mesh: Mesh, obstacle: Obstacle) -> tuple[Obstacle, FloatArray]:
    """Move an obstacle along the axis until it just touches the outer surface.

    The travel is found by Newton's method on the greatest penetration of all points of the surface, each of which is
    sought from the best of a grid by Nelder and Mead's method, for the obstacle need not be smooth.

    Parameters
    ----------
    mesh
        Of the skin; of a half one x >= 0.
    obstacle
        Anywhere.

    Returns
    -------
    obstacle, point
        The obstacle at first touch, and the point (3,) mm that it touches.

    Raises
    ------
    PalpateError
        If it passes by the skin, or touches its clamped rim first.
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
        "The obstacle does not touch the skin when it comes down along its axis.",
        "Move it nearer to the axis, or make it larger.",
        code="obstacle-misses-skin",
    )


def _deepest(mesh: Mesh, obstacle: Obstacle, disc: FloatArray) -> tuple[FloatArray, float]:
    """Point (3,) mm of the outer surface that lies deepest in the obstacle, and its penetration, mm."""

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
            "Move it nearer to the axis.",
            code="rim-touched-first",
        )
    if not mesh.spec.whole:
        best[0] = abs(best[0])
    return outside(best[None])[0], -float(found.fun)
