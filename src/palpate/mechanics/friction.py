"""Contact history: sticking places on the obstacle, and update by Coulomb's law (return mapping).

Sticking places and limits are fixed during a solve, so that every solve minimises a smooth energy, and corrected
between solves. After an increment, tangential springs longer than the friction limit are shortened to it: the return
mapping of plasticity, with slip for plastic strain (Wriggers 2006, chapter 5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.mechanics.obstacle import Obstacle

_SWEPT = 2.0 / 3.0
"""Share of its free slide that a point makes until it sticks, derived in docs/theory/contact.md."""


class ContactLaw(NamedTuple):
    """Parameters of the contact energy.

    Attributes
    ----------
    stiffness
        Normal penalty eps, MPa/mm.
    width
        Width w of its smooth onset, mm.
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
        """Return the contact pressure in MPa at penetrations (n,) mm."""
        inside = np.maximum(reach, 0.0)
        return np.where(
            inside < self.width,
            self.stiffness * inside**2 / (2 * self.width),
            self.stiffness * (inside - self.width / 2),
        )

    def friction_limit(self, reach: FloatArray) -> FloatArray:
        """Return the maximum tangential traction (n,) MPa at penetrations (n,) mm.

        It is infinite for no slip, and zero without contact.
        """
        if np.isinf(self.friction):
            return np.where(reach > 0, np.inf, 0.0)
        return self.friction * self.pressure(reach)


class ContactHistory(NamedTuple):
    """Sticking places of the contact points, and their traction limits.

    Attributes
    ----------
    anchor
        (n_points, 3) mm: sticking place of each point on the obstacle, relative to the obstacle's `point`.
    normal
        (n_points, 3) normal of the obstacle there.
    limit
        (n_points,) MPa maximum tangential traction; 0 for points that do not stick, infinite for no slip.
    stabilisation
        (n_points,) MPa/mm spring that pulls a lifting point back to the obstacle (see `palpate.fea.monitor`).
    """

    anchor: FloatArray
    normal: FloatArray
    limit: FloatArray
    stabilisation: FloatArray


class ContactPair(NamedTuple):
    """Contact points (n_points, 3) mm and the obstacle that they may touch."""

    points: FloatArray
    obstacle: Obstacle


def empty_history(points: int) -> ContactHistory:
    """Return the history before any contact."""
    return ContactHistory(np.zeros((points, 3)), np.zeros((points, 3)), np.zeros(points), np.zeros(points))


def correct_history(
    law: ContactLaw, history: ContactHistory, before: ContactPair, after: ContactPair, area: FloatArray
) -> ContactHistory:
    """Correct sticking places and limits by a solution in which points in new contact slid freely.

    `before` is the last equilibrium, `after` the solution, `area` (n_points,) mm² the area of each point. A point in
    new contact sticks at its place of contact; one that lost contact no longer sticks. The time of contact follows
    from the area: points closer to the obstacle in `before` touch first, and the patch grows at a constant rate. The
    path of a point up to that time is estimated from its path in the solution, in which the patch sticks only up to
    its old edge. Ahead of the edge of the sticking region, a free surface moves as the square root of the distance
    from it. While the edge advances at the rate L, a point at x, reached at the share a = x / L of the increment,
    therefore moves by ``∫ sqrt(x - L t) dt = 2/3 a sqrt(x)``, while it moves by ``sqrt(x)`` in the solution
    (docs/theory/contact.md). In the first increment no point sticks yet, and a point slides until its time of
    contact.
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
    """Return the share of the increment (n_points,) at which a growing patch reaches its fresh points.

    It is 0 for points that are not fresh.
    """
    share, order = np.zeros(len(distance)), np.flatnonzero(fresh)
    order = order[np.argsort(distance[order], kind="stable")]
    share[order] = np.cumsum(area[order]) - 0.5 * area[order]
    share /= max(float(area[order].sum()), np.finfo(float).tiny)
    return share


def return_to_limit(law: ContactLaw, history: ContactHistory, at: ContactPair) -> ContactHistory:
    """Return the history after an equilibrium: sticking places after any slip (return mapping)."""
    reach, place = at.obstacle.closest_points(at.points)
    spring = np.where(history.limit[:, None] > 0, place - history.anchor, 0.0)
    length = law.tangential_stiffness * np.linalg.norm(spring, axis=1)
    kept = np.divide(history.limit, length, out=np.ones_like(length), where=length > history.limit)
    anchor = place - kept[:, None] * spring
    limit = law.friction_limit(reach)
    return ContactHistory(anchor, at.obstacle.normal_at(anchor), limit, history.stabilisation)


def dissipated(law: ContactLaw, history: ContactHistory, at: ContactPair, weight: FloatArray) -> float:
    """Return the work of friction, mJ, in the increment that ends here: traction times slip.

    `weight` (n_points,) mm² are the areas of the points.
    """
    if not 0 < law.friction < np.inf:
        return 0.0
    _, place = at.obstacle.closest_points(at.points)
    length = np.linalg.norm(place - history.anchor, axis=1)
    slip = np.maximum(length - history.limit / law.tangential_stiffness, 0.0)
    return float((weight * history.limit * slip).sum())
