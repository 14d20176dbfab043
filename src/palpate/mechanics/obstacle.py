"""Rigid obstacles: what a body may press against, asked for distance, normal and curvature near any point.

Contact needs of an obstacle only its gap function: the penetration ``delta(x)`` of a point, positive inside, its
gradient ``n``, which points into the obstacle, and its Hessian (Wriggers, *Computational Contact Mechanics*, 2006,
chapter 4: closest point projection). An obstacle moves and may turn where that does not change its surface; what
sticks to it moves with it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple, Self

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError


class Gap(NamedTuple):
    """Penetration of points with its derivatives.

    Attributes
    ----------
    penetration
        (n,) mm penetration, positive inside the obstacle.
    normal
        (n, 3) unit gradient of `penetration`, from the surface into the obstacle.
    curvature
        (n, 3, 3) 1/mm Hessian of `penetration`; None for a flat obstacle.
    """

    penetration: FloatArray
    normal: FloatArray
    curvature: FloatArray | None


class Obstacle(ABC):
    """A rigid body that a solid may touch.

    Attributes
    ----------
    point
        (3,) mm, a point that moves with the obstacle.
    axes
        (3, 3) the obstacle's own axes as columns, in which places on it are kept; None as long as it has not turned.
    """

    point: FloatArray
    axes: FloatArray | None = None

    @abstractmethod
    def moved(self, by: FloatArray) -> Self:
        """Return the obstacle moved by (3,) mm."""

    @abstractmethod
    def gap(self, points: FloatArray) -> Gap:
        """Penetration of points (n, 3) mm, with its gradient and Hessian."""

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        """Quadrilaterals of the surface about a point of it, as other programs and pictures want them.

        Parameters
        ----------
        at
            (3,) mm, a point of the surface.
        half
            Half their breadth, mm; less where the obstacle is smaller.

        Returns
        -------
        points, quadrilaterals
            (m, 3) mm and (k, 4) numbers of points, counter-clockwise seen from inside the obstacle.

        Raises
        ------
        PalpateError
            If the obstacle gives none.
        """
        raise PalpateError(
            f"The obstacle {type(self).__name__} has no quadrilaterals to write or draw.",
            "Give it a method `patch`.",
            code="obstacle-no-patch",
        )

    def penetration(self, points: FloatArray) -> FloatArray:
        """Penetration (n,) mm of points (n, 3) mm; negative off the obstacle."""
        return self.gap(points).penetration

    def normal_at(self, place: FloatArray) -> FloatArray:
        """Normals (n, 3) at places (n, 3) mm seen from `point`, in the obstacle's axes."""
        return self.gap(self.point + self.to_global_frame(place)).normal

    def to_global_frame(self, place: FloatArray) -> FloatArray:
        """Places (n, 3) mm of the obstacle's own axes in those of space."""
        return place if self.axes is None else place @ self.axes.T

    def closest_points(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Penetration (n,) mm of points (n, 3) mm, and the places (n, 3) mm nearest to them.

        A place is seen from `point`, in the obstacle's own axes.
        """
        reach = self.penetration(points)
        place = points - self.point - reach[:, None] * self.gap(points).normal
        return reach, place if self.axes is None else place @ self.axes


def tangents(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (3,) across a normal (3,), the first nearest to x; with it they are right-handed."""
    along = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    along /= np.linalg.norm(along)
    return along, np.cross(normal, along)


def grid_quads(rows: int, columns: int) -> IntArray:
    """Quadrilaterals (k, 4) of a grid of points numbered row by row, counter-clockwise."""
    number = np.arange(rows * columns).reshape(rows, columns)
    return np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
