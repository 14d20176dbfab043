"""Rigid obstacles: distance, normal and curvature at any point.

Contact requires only the gap function of an obstacle: the penetration ``delta(x)`` of a point, positive inside, its
gradient ``n``, which points into the obstacle, and its Hessian (Wriggers, *Computational Contact Mechanics*, 2006,
chapter 4: closest point projection). An obstacle moves, and may rotate if that does not change its surface; points
that stick to it move with it.
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
        (3, 3) the obstacle's own axes as columns, in which places on it are stored; None if it has not rotated.
    """

    point: FloatArray
    axes: FloatArray | None = None

    @abstractmethod
    def moved(self, by: FloatArray) -> Self:
        """Return the obstacle moved by (3,) mm."""

    @abstractmethod
    def gap(self, points: FloatArray) -> Gap:
        """Return the penetration of points (n, 3) mm, with its gradient and Hessian."""

    def patch(self, at: FloatArray, half: float) -> tuple[FloatArray, IntArray]:
        """Return quadrilaterals of the surface about a point of it, for other programs and figures.

        Parameters
        ----------
        at
            (3,) mm, a point of the surface.
        half
            Half their width, mm; less if the obstacle is smaller.

        Returns
        -------
        points, quadrilaterals
            (m, 3) mm and (k, 4) numbers of points, counter-clockwise seen from inside the obstacle.

        Raises
        ------
        PalpateError
            If the obstacle does not implement them.
        """
        raise PalpateError(
            f"The obstacle {type(self).__name__} has no surface quadrilaterals for decks and figures.",
            "Implement its method `patch`.",
            code="obstacle-no-patch",
        )

    def penetration(self, points: FloatArray) -> FloatArray:
        """Return the penetration (n,) mm of points (n, 3) mm; negative outside the obstacle."""
        return self.gap(points).penetration

    def depth_below(self, points: FloatArray) -> FloatArray:
        """Return the penetration (n,) mm of points (n, 3) mm if holes are filled; it decides the branch."""
        return self.penetration(points)

    def normal_at(self, place: FloatArray) -> FloatArray:
        """Return the normals (n, 3) at places (n, 3) mm relative to `point`, in the obstacle's axes."""
        return self.gap(self.point + self.to_global_frame(place)).normal

    def to_global_frame(self, place: FloatArray) -> FloatArray:
        """Convert places (n, 3) mm in the obstacle's axes to the axes of space."""
        return place if self.axes is None else place @ self.axes.T

    def closest_points(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the penetration (n,) mm of points (n, 3) mm, and the closest places (n, 3) mm.

        A place is relative to `point`, in the obstacle's own axes.
        """
        reach = self.penetration(points)
        place = points - self.point - reach[:, None] * self.gap(points).normal
        return reach, place if self.axes is None else place @ self.axes


def tangents(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors (3,) across a normal (3,), right-handed with it, the first closest to x."""
    along = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    along /= np.linalg.norm(along)
    return along, np.cross(normal, along)


def grid_quads(rows: int, columns: int) -> IntArray:
    """Return the quadrilaterals (k, 4) of a grid of points numbered row by row, counter-clockwise."""
    number = np.arange(rows * columns).reshape(rows, columns)
    return np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
