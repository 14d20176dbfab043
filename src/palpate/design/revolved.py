"""Skins of revolution by their meridian: what `Skin` asks, answered by numbers for any smooth curve.

The meridian runs from the apex (parameter 0) to the rim (1) and may go on a little beyond. The wall lies between it
and the curve at the distance of its thickness along the normals. Points are carried to the meridian by their distance
from the axis and their height; the nearest point is found from a table and by Newton's method.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from palpate.cad import Outline, SmoothCurve
from palpate.core import FloatArray
from palpate.design.skin import Rim, Skin, Symmetry

_TABLE = 2001
"""Points of the tables along the meridian."""
_BEYOND = 1.25
"""Parameter to which the tables reach."""
_NEWTON = 8
_FIRST, _MARCH = 4, 60
"""Steps along a ray, each as long as the distance to the surface: before Newton's, and where these fail."""
_GRAZING, _HIT_MM = 0.05, 1e-9
"""Least slope of the distance along a ray that a step is taken by, and distance at which a ray has hit."""
_SECTION = 33
"""Points of the curve that the CAD kernel is given."""


class RevolvedSkin(Skin):
    """A skin of revolution; a final one gives its meridian with first and second derivative."""

    @abstractmethod
    def curve(self, t: FloatArray, order: int = 0) -> FloatArray:
        """Meridian (n, 2) mm as distance from the axis and height, or a derivative of it, at parameters (n,)."""

    @property
    def symmetry(self) -> Symmetry:
        return Symmetry.REVOLVED

    def _normals(self, t: FloatArray) -> FloatArray:
        slope = self.curve(t, 1)
        return np.column_stack([-slope[:, 1], slope[:, 0]]) / np.linalg.norm(slope, axis=1)[:, None]

    @cached_property
    def _table(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Parameters (n,), meridian (n, 2) and length (n,) along it."""
        t = np.linspace(0.0, _BEYOND, _TABLE)
        curve, speed = self.curve(t), np.linalg.norm(self.curve(t, 1), axis=1)
        steps = np.diff(t) * (speed[1:] + speed[:-1]) / 2
        return t, curve, np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def _near(self) -> cKDTree:
        """Finds the nearest of every tenth point of the table."""
        return cKDTree(self._table[1][::10])

    @property
    def widest(self) -> tuple[float, float]:
        t, curve, _ = self._table
        best = int(curve[t <= 1.0, 0].argmax())
        if curve[best, 0] <= self.base_radius * (1 + 1e-9):
            return self.base_radius, 0.0
        return float(curve[best, 0]), float(curve[best, 1])

    def _end(self, offset: float, rim: Rim) -> float:
        """Parameter at which the curve `offset` mm outside the meridian meets the base."""
        if rim is Rim.RADIAL or offset == 0.0:
            return 1.0
        t, _, _ = self._table
        height = (self.curve(t) + offset * self._normals(t))[:, 1]
        last = int(np.flatnonzero(height >= 0)[-1])
        low, high = float(t[last]), float(t[min(last + 1, len(t) - 1)])
        for _ in range(60):
            middle = (low + high) / 2
            at = np.array([middle])
            above = (self.curve(at) + offset * self._normals(at))[0, 1] >= 0
            low, high = (middle, high) if above else (low, middle)
        return low

    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        offset = layer * self.thickness
        s = np.hypot(disc[:, 0], disc[:, 1])
        t = s * self._end(offset, rim)
        place = self.curve(t) + offset * self._normals(t)
        direction = np.divide(disc, s[:, None], out=np.zeros_like(disc), where=s[:, None] > 0)
        return np.column_stack([place[:, :1] * direction, place[:, 1]])

    def _foot(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Parameter (n,) of the meridian's nearest point, and direction (n, 2) about the axis, of points (n, 3)."""
        rho = np.hypot(points[:, 0], points[:, 1])
        direction = np.divide(points[:, :2], rho[:, None], out=np.zeros((len(points), 2)), where=rho[:, None] > 0)
        place = np.column_stack([rho, points[:, 2]])
        t = self._table[0][10 * self._near.query(place)[1]]
        for _ in range(_NEWTON):
            gap, slope = place - self.curve(t), self.curve(t, 1)
            fall = (slope**2).sum(axis=1) - (gap * self.curve(t, 2)).sum(axis=1)
            step = (gap * slope).sum(axis=1) / np.where(fall > 0, fall, (slope**2).sum(axis=1))
            t = np.clip(t + step, 0.0, _BEYOND)
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
        return self._gap(points.reshape(-1, 3))[0].reshape(points.shape[:-1])

    def _gap(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distance (n,) of points (n, 3) from the surface, positive outside, and its normals (n, 3) there."""
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
        """Along each ray from inside: by the distance to the surface (Hart 1996, sphere tracing), then by Newton.

        The distance is as steep along a ray as the normal leans to it; where that does not end, by marching alone.
        """
        unit = rays / np.linalg.norm(rays, axis=1)[:, None]
        points = np.tile(np.asarray(origin, float), (len(rays), 1))
        enter = np.where(points[:, 2] < 0, -points[:, 2] / np.where(unit[:, 2] > 0, unit[:, 2], np.nan), 0.0)
        points = points + enter[:, None] * unit
        inside = np.hypot(points[:, 0], points[:, 1]) <= self.base_radius
        points[~(inside & np.isfinite(points[:, 2]))] = np.nan
        found = np.isfinite(points[:, 0])
        start = points.copy()
        for step in range(_FIRST + _NEWTON):
            gap, normals = self._gap(points[found])
            steep = (normals * unit[found]).sum(axis=1) if step >= _FIRST else np.ones(len(gap))
            points[found] -= (gap / np.maximum(steep, _GRAZING))[:, None] * unit[found]
        astray = np.flatnonzero(found)[np.abs(self.distance(points[found])) > _HIT_MM]
        points[astray] = start[astray]
        for _ in range(_MARCH if len(astray) else 0):
            points[astray] -= self.distance(points[astray])[:, None] * unit[astray]
        return points

    def touch(self, normal: FloatArray) -> FloatArray:
        t = self._slope_at(float(np.arctan2(np.hypot(normal[0], normal[1]), normal[2])))
        place = (self.curve(t) + self.thickness * self._normals(t))[0]
        across = np.hypot(normal[0], normal[1])
        direction = np.array([normal[0], normal[1]]) / across if across > 0 else np.zeros(2)
        return np.array([*(place[0] * direction), place[1]])

    def _slope_at(self, angle: float) -> FloatArray:
        """Parameter (1,) at which the normal leans by an angle (rad) from the axis."""
        low, high = 0.0, _BEYOND
        for _ in range(60):
            middle = (low + high) / 2
            n = self._normals(np.array([middle]))[0]
            low, high = (middle, high) if np.arctan2(n[0], n[1]) < angle else (low, middle)
        return np.array([low])

    @property
    def inner_slope(self) -> float:
        n = self._normals(np.ones(1))[0]
        return float(np.arctan2(n[0], n[1]))

    def rim_slope(self, rim: Rim) -> float:
        n = self._normals(np.array([self._end(self.thickness, rim)]))[0]
        return float(np.arctan2(n[0], n[1]))

    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
        edge = self.point(np.array([[1.0, 0.0]]), 1.0, rim)[0]
        return float((self.touch(normal) - edge) @ normal / np.cos(tilt))

    def meridian(self, offset: float, *, down: bool) -> Outline:
        t = np.linspace(0.0, self._end(offset, Rim.FLAT), _SECTION)
        place = self.curve(t) + offset * self._normals(t)
        place[0, 0], place[-1, 1] = 0.0, 0.0
        points = place[1:] if down else place[-2::-1]
        return [SmoothCurve(tuple((float(x), float(z)) for x, z in points))]
