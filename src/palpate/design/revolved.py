"""Skins of revolution: numerical geometry of `Skin` for any smooth meridian.

The meridian runs from the apex (parameter 0) to the rim (1) and may extend slightly beyond. The skin lies between it
and the curve at the distance of its thickness along the normals; the thickness changes from apex to rim by the taper.
Points are mapped to the plane of the meridian by their distance from the axis and their height. The nearest point is
found from a table and by Newton's method.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray
from palpate.design.outline import Outline, SmoothCurve
from palpate.design.ray import trace_rays
from palpate.design.skin import Rim, Skin, Symmetry

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_TABLE = 2001
"""Number of points of the tables along the meridian. By hand."""
BEYOND = 1.25
"""Parameter up to which the tables extend. By hand."""
_NEWTON, _STILL = 8, 1e-9
"""Maximum number of Newton steps, and a step size after which the next, its square, is negligible."""
_SECTION = 33
"""Number of points of the curve for the CAD kernel. By hand."""


class RevolvedSkin(Skin):
    """Skin of revolution; a subclass gives its meridian with first and second derivative.

    Attributes
    ----------
    taper
        Ratio of the skin thickness at the rim to that at the apex: ``T(t) = T (1 + (taper - 1) t²)``.
    """

    taper: float = 1.0

    @property
    def name(self) -> str:
        return super().name + (f" taper {self.taper:g}" if self.taper != 1.0 else "")

    @abstractmethod
    def curve(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Return the meridian (n, 2) mm (distance from the axis, height) or a derivative at parameters (n,)."""

    @property
    def symmetry(self) -> Symmetry:
        return Symmetry.REVOLVED

    def wall_thickness(self, t: FloatArray) -> FloatArray:
        """Return the thickness (n,) mm along the normals at parameters (n,)."""
        return np.asarray(self.thickness * (1.0 + (self.taper - 1.0) * t**2))

    @property
    def rim_thickness(self) -> float:
        return self.thickness * self.taper

    def _outside(self, t: FloatArray, layer: float = 1.0) -> FloatArray:
        """Return points (n, 2) mm of a layer at parameters (n,)."""
        return np.asarray(self.curve(t) + layer * self.wall_thickness(t)[:, None] * self._normals(t))

    def _hollow(self, t: FloatArray) -> FloatArray:
        """Return the curvature κ (n,) 1/mm of the meridian, positive if concave from outside."""
        slope, bend = self.curve(t, 1), self.curve(t, 2)
        turn: FloatArray = slope[:, 0] * bend[:, 1] - slope[:, 1] * bend[:, 0]
        return np.asarray(turn / np.linalg.norm(slope, axis=1) ** 3)

    def _outer_slopes(self, t: FloatArray) -> FloatArray:
        """Return the derivative (n, 2) mm of the outer surface: ``c' + T' ν + T ν'`` with ``ν' = -κ c'``."""
        steeper = 2.0 * self.thickness * (self.taper - 1.0) * t
        longer = 1.0 - self.wall_thickness(t) * self._hollow(t)
        return np.asarray(longer[:, None] * self.curve(t, 1) + steeper[:, None] * self._normals(t))

    def _normals(self, t: FloatArray) -> FloatArray:
        slope = self.curve(t, 1)
        return np.column_stack([-slope[:, 1], slope[:, 0]]) / np.linalg.norm(slope, axis=1)[:, None]

    @cached_property
    def _table(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Parameters (n,), meridian (n, 2) and length (n,) along it."""
        t = np.linspace(0.0, BEYOND, _TABLE)
        curve, speed = self.curve(t), np.linalg.norm(self.curve(t, 1), axis=1)
        steps = np.diff(t) * (speed[1:] + speed[:-1]) / 2
        return t, curve, np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def _near(self) -> cKDTree:
        """Search tree of every tenth point of the table."""
        from scipy.spatial import cKDTree

        return cKDTree(self._table[1][::10])

    @property
    def widest(self) -> tuple[float, float]:
        t, curve, _ = self._table
        best = int(curve[t <= 1.0, 0].argmax())
        if curve[best, 0] <= self.base_radius * (1 + 1e-9):
            return self.base_radius, 0.0
        return float(curve[best, 0]), float(curve[best, 1])

    @property
    def outer_widest(self) -> tuple[float, float]:
        if self.taper == 1.0:
            return super().outer_widest
        outer = self._outside(np.linspace(0.0, self._end(1.0, Rim.FLAT), _TABLE))
        best = int(outer[:, 0].argmax())
        return float(outer[best, 0]), float(max(outer[best, 1], 0.0))

    def _end(self, layer: float, rim: Rim) -> float:
        """Return the parameter at which a layer meets the base."""
        if rim is Rim.RADIAL or layer == 0.0:
            return 1.0
        if layer not in self._base_ends:
            self._base_ends[layer] = self._meet_base(layer)
        return self._base_ends[layer]

    @cached_property
    def _base_ends(self) -> dict[float, float]:
        """Parameters at which layers meet a flat base, by layer."""
        return {}

    def _meet_base(self, layer: float) -> float:
        t, _, _ = self._table
        height = self._outside(t, layer)[:, 1]
        last = int(np.flatnonzero(height >= 0)[-1])
        low, high = float(t[last]), float(t[min(last + 1, len(t) - 1)])
        for _ in range(60):
            middle = (low + high) / 2
            at = np.array([middle])
            above = self._outside(at, layer)[0, 1] >= 0
            low, high = (middle, high) if above else (low, middle)
        return low

    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        s = np.hypot(disc[:, 0], disc[:, 1])
        place = self._outside(s * self._end(layer, rim), layer)
        direction = np.divide(disc, s[:, None], out=np.zeros_like(disc), where=s[:, None] > 0)
        return np.column_stack([place[:, :1] * direction, place[:, 1]])

    def _foot(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the parameter (n,) of the meridian's nearest point, and direction (n, 2) about the axis."""
        rho = np.hypot(points[:, 0], points[:, 1])
        direction = np.divide(points[:, :2], rho[:, None], out=np.zeros((len(points), 2)), where=rho[:, None] > 0)
        place = np.column_stack([rho, points[:, 2]])
        t = self._table[0][10 * self._near.query(place)[1]]
        for _ in range(_NEWTON):
            gap, slope = place - self.curve(t), self.curve(t, 1)
            fall = (slope**2).sum(axis=1) - (gap * self.curve(t, 2)).sum(axis=1)
            step = (gap * slope).sum(axis=1) / np.where(fall > 0, fall, (slope**2).sum(axis=1))
            before, t = t, np.clip(t + step, 0.0, BEYOND)
            if np.abs(t - before).max(initial=0.0) < _STILL:
                break
        return t, direction

    def _spread(self, values: FloatArray, direction: FloatArray) -> FloatArray:
        return np.column_stack([values[:, :1] * direction, values[:, 1]])

    def disc(self, points: FloatArray) -> FloatArray:
        t, direction = self._foot(points)
        return np.asarray(t[:, None] * direction)

    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        rho, azimuth = np.broadcast_arrays(np.asarray(rho, float), np.asarray(azimuth, float))
        t, curve, _ = self._table
        upper = int(curve[t <= 1.0, 0].argmax())
        at = np.interp(rho.ravel(), curve[: upper + 1, 0], t[: upper + 1])
        for _ in range(_NEWTON):
            slope = np.maximum(self.curve(at, 1)[:, 0], 1e-3 * self.base_radius)
            at = np.clip(at + (rho.ravel() - self.curve(at)[:, 0]) / slope, 0.0, t[upper])
        height = self.curve(at)[:, 1].reshape(rho.shape)
        height = np.where(rho <= self.widest[0] * (1.0 + 1e-9), height, np.nan)
        return np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth), height], axis=-1)

    def normal(self, points: FloatArray) -> FloatArray:
        points = np.asarray(points, float)
        t, direction = self._foot(points.reshape(-1, 3))
        return self._spread(self._normals(t), direction).reshape(points.shape)

    def nearest(self, points: FloatArray) -> FloatArray:
        points = np.asarray(points, float)
        t, direction = self._foot(points.reshape(-1, 3))
        return self._spread(self.curve(t), direction).reshape(points.shape)

    def distance(self, points: ArrayLike) -> FloatArray:
        points = np.asarray(points, float)
        return self.gap(points.reshape(-1, 3))[0].reshape(points.shape[:-1])

    def gap(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distance (n,) mm of points (n, 3) mm from the inner surface, and its normals (n, 3)."""
        t, direction = self._foot(points)
        normals = self._spread(self._normals(t), direction)
        return ((points - self._spread(self.curve(t), direction)) * normals).sum(axis=1), normals

    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        points = np.asarray(points, float)
        knots, _, length = self._table
        left = np.interp(1.0, knots, length) - self.arc_length(points.reshape(-1, 3))
        return np.asarray(left.reshape(points.shape[:-1]))

    def arc_length(self, points: FloatArray) -> FloatArray:
        knots, _, length = self._table
        return np.interp(self._foot(points)[0], knots, length)

    def at_arc_length(self, length: FloatArray) -> FloatArray:
        knots, _, lengths = self._table
        return np.asarray(self.curve(np.interp(length, lengths, knots))[:, 0])

    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        return trace_rays(self.gap, lambda at: np.hypot(at[:, 0], at[:, 1]) <= self.base_radius, origin, rays)

    def support_point(self, normal: FloatArray) -> FloatArray:
        across = np.hypot(normal[0], normal[1])
        place = self._outside(self._highest(np.array([across, normal[2]])))[0]
        direction = np.array([normal[0], normal[1]]) / across if across > 0 else np.zeros(2)
        return np.array([*(place[0] * direction), place[1]])

    @cached_property
    def _outer_table(self) -> FloatArray:
        return self._outside(self._table[0])

    def _highest(self, way: FloatArray) -> FloatArray:
        """Return the parameter (1,) of the outer surface's extreme point in a direction, nearest to the apex."""
        t, height = self._table[0], self._outer_table @ way
        best = int(np.flatnonzero(height >= height.max() - 1e-12 * self.base_radius)[0])
        low, high = float(t[max(best - 1, 0)]), float(t[min(best + 1, len(t) - 1)])
        for _ in range(60):
            middle = (low + high) / 2
            rises = (self._outer_slopes(np.array([middle])) @ way)[0] > 0
            low, high = (middle, high) if rises else (low, middle)
        return np.array([low])

    @property
    def inner_slope(self) -> float:
        n = self._normals(np.ones(1))[0]
        return float(np.arctan2(n[0], n[1]))

    def rim_slope(self, rim: Rim) -> float:
        slope = self._outer_slopes(np.array([self._end(1.0, rim)]))[0]
        return float(np.arctan2(-slope[1], slope[0]))

    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
        edge = self.point(np.array([[1.0, 0.0]]), 1.0, rim)[0]
        return float((self.support_point(normal) - edge) @ normal / np.cos(tilt))

    def meridian(self, offset: float, *, down: bool) -> Outline:
        if offset > 0:
            layer = offset / self.thickness
            place = self._outside(np.linspace(0.0, self._end(layer, Rim.FLAT), _SECTION), layer)
        else:
            place = self._parallel(offset)
        place[0, 0], place[-1, 1] = 0.0, 0.0
        points = place[1:] if down else place[-2::-1]
        return [SmoothCurve(tuple((float(x), float(z)) for x, z in points))]

    def _parallel(self, offset: float) -> FloatArray:
        """Return points (n, 2) mm of the curve `offset` mm outside the meridian, from the axis to the base."""
        t = self._table[0]
        height = (self.curve(t) + offset * self._normals(t))[:, 1]
        end = float(np.interp(0.0, -height[len(t) // 2 :], t[len(t) // 2 :])) if offset else 1.0
        t = np.linspace(0.0, end, _SECTION)
        return np.asarray(self.curve(t) + offset * self._normals(t))


def plain_numbers(kind: str, numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a skin of revolution as its spec reads them; a taper of 1 is left out."""
    return {"kind": kind, **{name: value for name, value in numbers.items() if name != "taper" or value != 1.0}}
