"""Intersections of rays with a skin from inside, by sphere tracing and Newton's method.

Spheres, and ellipsoids after scaling, are solved by a quadratic equation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray

Gap = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Function of points (n, 3) mm: distance (n,) outside the surface, or less, and its gradient (n, 3)."""
Within = Callable[[FloatArray], BoolArray]

_FIRST, _NEWTON, _MARCH = 4, 8, 60
"""Steps along a ray: sphere tracing, Newton's method, sphere tracing without it. By hand."""
_GRAZING, _HIT_MM = 0.05, 1e-9
"""Minimum slope of the gap along a ray in a step, and maximum gap of a solution. By hand."""


def trace_rays(gap: Gap, within: Within, origin: FloatArray, rays: FloatArray) -> FloatArray:
    """Return the points (n, 3) mm where rays leave a surface from inside.

    Sphere tracing (Hart 1996) is followed by Newton's method; rays that do not converge repeat it with more tracing.
    The gap of the surface must not change faster than its distance. `within` returns whether points (n, 3) at or
    above the base, from where rays start, are inside (n,). For `origin` and `rays` see `Skin.hit`; a ray that does
    not pass the base is NaN.
    """
    unit = rays / np.linalg.norm(rays, axis=1)[:, None]
    points = pass_base(within, origin, unit)
    found = np.flatnonzero(np.isfinite(points[:, 0]))
    start = points.copy()
    _go(gap, points, unit, found, _FIRST)
    astray = found[np.abs(gap(points[found])[0]) > _HIT_MM]
    points[astray] = start[astray]
    _go(gap, points, unit, astray, _MARCH)
    return points


def _go(gap: Gap, points: FloatArray, unit: FloatArray, which: IntArray, march: int) -> None:
    """Move points along their rays, first by `march` steps of their gap, then by Newton's method."""
    for step in range(march + _NEWTON if len(which) else 0):
        far, slope = gap(points[which])
        steep = (slope * unit[which]).sum(axis=1) if step >= march else np.ones(len(far))
        points[which] -= (far / np.maximum(steep, _GRAZING))[:, None] * unit[which]


def pass_base(within: Within, origin: FloatArray, rays: FloatArray) -> FloatArray:
    """Return points (n, 3) mm where rays pass the base or start above it; NaN if they are outside there."""
    points = np.broadcast_to(np.asarray(origin, float), rays.shape).copy()
    enter = np.where(points[:, 2] < 0, -points[:, 2] / np.where(rays[:, 2] > 0, rays[:, 2], np.nan), 0.0)
    points = points + enter[:, None] * rays
    points[~(within(points) & np.isfinite(points[:, 2]))] = np.nan
    return points


def leave_sphere(start: FloatArray, rays: FloatArray, radius: float) -> FloatArray:
    """Return the multiple (n,) of each ray to the second root of ``|s + x d| = r``; NaN if it misses.

    Rays have start points (n, 3) or (3,) relative to the sphere's centre, and directions (n, 3); the radius is in mm.
    """
    along, square = (rays * start).sum(axis=1), (rays**2).sum(axis=1)
    root = along**2 - square * ((start**2).sum(axis=-1) - radius**2)
    return np.asarray((-along + np.sqrt(np.where(root >= 0, root, np.nan))) / square)
