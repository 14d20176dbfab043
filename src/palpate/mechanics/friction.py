"""Contact history: where each point sticks to the obstacle, and how Coulomb's law carries that on (return mapping).

During a solve sticking places and limits stand still, so that every solve minimises a smooth energy; between solves
they are corrected, and after an increment the tangential springs longer than the friction limit are pulled back to
it: the return mapping of plasticity, with slip for plastic strain (Wriggers 2006, chapter 5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.mechanics.obstacle import Obstacle

_SWEPT = 2.0 / 3.0
"""Share of its free slide that a point makes before the edge of what sticks reaches it."""


class ContactLaw(NamedTuple):
    """Numbers of the contact energy.

    Attributes
    ----------
    stiffness
        Normal penalty eps, MPa/mm.
    width
        Width w of its smooth start, mm.
    tangential_stiffness
        Spring eps_t, MPa/mm.
    friction
        Coefficient of friction mu: 0 frictionless, infinity no slip.
    """

    stiffness: float
    width: float
    tangential_stiffness: float
    friction: float

    def pressure(self, reach: FloatArray) -> FloatArray:
        """Contact pressure in MPa at penetrations (n,) mm."""
        inside = np.maximum(reach, 0.0)
        return np.where(
            inside < self.width,
            self.stiffness * inside**2 / (2 * self.width),
            self.stiffness * (inside - self.width / 2),
        )

    def friction_limit(self, reach: FloatArray) -> FloatArray:
        """Greatest tangential traction (n,) MPa at penetrations (n,) mm; infinite for no slip, zero off the wall."""
        if np.isinf(self.friction):
            return np.where(reach > 0, np.inf, 0.0)
        return self.friction * self.pressure(reach)


class ContactHistory(NamedTuple):
    """Where the contact points stick, and how hard.

    Attributes
    ----------
    anchor
        (n_points, 3) mm: the place on the obstacle that each point sticks to, seen from the obstacle's `point`.
    normal
        (n_points, 3) normal of the obstacle there.
    limit
        (n_points,) MPa greatest tangential traction; 0 for points that do not stick, infinite for no slip.
    stabilisation
        (n_points,) MPa/mm spring that pulls a lifting point back to the obstacle (see `palpate.fea.monitor`).
    """

    anchor: FloatArray
    normal: FloatArray
    limit: FloatArray
    stabilisation: FloatArray


class ContactPair(NamedTuple):
    """Contact points (n_points, 3) mm and the obstacle that they meet."""

    points: FloatArray
    obstacle: Obstacle


def empty_history(points: int) -> ContactHistory:
    """Nothing has touched yet."""
    return ContactHistory(np.zeros((points, 3)), np.zeros((points, 3)), np.zeros(points), np.zeros(points))


def correct_history(
    law: ContactLaw, history: ContactHistory, before: ContactPair, after: ContactPair, area: FloatArray
) -> ContactHistory:
    """Correct sticking places and limits by a solution in which points that touch anew slid freely.

    `before` is the last equilibrium, `after` the solution, `area` (n_points,) mm² what each point stands for. A point
    that came to touch sticks where it touched; one that left sticks no more. When a point is reached is read from the
    area: the nearer ones of `before` come first, and the patch grows evenly. Its path up to then is read from that of
    the solution, in which the patch sticks only up to its old edge. Beside the edge of what sticks a free surface
    moves as the root of the distance from it. So while the edge sweeps on at the rate L, a point at x, reached at the
    share a = x / L of the increment, moves ``∫ sqrt(x - L t) dt = 2/3 a sqrt(x)``, where the solution gives
    ``sqrt(x)`` (docs/design_notes/mechanics.md). In the first increment nothing sticks yet, and a point slides up to
    its time.
    """
    reach0, place0 = before.obstacle.closest_points(before.points)
    reach1, place1 = after.obstacle.closest_points(after.points)
    fresh = (history.limit == 0) & (reach1 > 0)
    swept = arrival(-reach0, fresh, area)
    if (history.limit > 0).any():
        swept *= _SWEPT
    touched = place0 + swept[:, None] * (place1 - place0)
    anchor = np.where(fresh[:, None], touched, history.anchor)
    normal = np.where(fresh[:, None], after.obstacle.normal_at(anchor), history.normal)
    return ContactHistory(anchor, normal, law.friction_limit(reach1), history.stabilisation)


def arrival(distance: FloatArray, fresh: BoolArray, area: FloatArray) -> FloatArray:
    """Share of the increment (n_points,) at which a patch that grows evenly reaches its fresh points; 0 of others."""
    share, order = np.zeros(len(distance)), np.flatnonzero(fresh)
    order = order[np.argsort(distance[order], kind="stable")]
    share[order] = np.cumsum(area[order]) - 0.5 * area[order]
    share /= max(float(area[order].sum()), np.finfo(float).tiny)
    return share


def return_to_limit(law: ContactLaw, history: ContactHistory, at: ContactPair) -> ContactHistory:
    """What the points keep of an equilibrium: where they stick, after any slip (return mapping)."""
    reach, place = at.obstacle.closest_points(at.points)
    spring = np.where(history.limit[:, None] > 0, place - history.anchor, 0.0)
    length = law.tangential_stiffness * np.linalg.norm(spring, axis=1)
    kept = np.divide(history.limit, length, out=np.ones_like(length), where=length > history.limit)
    anchor = place - kept[:, None] * spring
    limit = law.friction_limit(reach)
    return ContactHistory(anchor, at.obstacle.normal_at(anchor), limit, history.stabilisation)


def dissipated(law: ContactLaw, history: ContactHistory, at: ContactPair, weight: FloatArray) -> float:
    """Work in mJ of friction in the increment that ends here: traction times slip, over areas (n_points,) mm²."""
    if not 0 < law.friction < np.inf:
        return 0.0
    _, place = at.obstacle.closest_points(at.points)
    length = np.linalg.norm(place - history.anchor, axis=1)
    slip = np.maximum(length - history.limit / law.tangential_stiffness, 0.0)
    return float((weight * history.limit * slip).sum())
