"""Where rays leave a skin: by its distance, or anything that grows no faster, first; then by Newton's method.

What is a sphere, or is one where it is stretched along its axis, is left where a quadratic says.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray

Gap = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""From points (n, 3) mm to how far outside the surface they are (n,), and the slope (n, 3) of that."""
Within = Callable[[FloatArray], BoolArray]

_FIRST, _NEWTON, _MARCH = 4, 8, 60
"""Steps along a ray, each as long as the gap: before Newton's, of these, and where they fail."""
_GRAZING, _HIT_MM = 0.05, 1e-9
"""Least slope of the gap along a ray that a step is taken by, and gap at which a ray has hit."""


def trace_rays(gap: Gap, within: Within, origin: FloatArray, rays: FloatArray) -> FloatArray:
    """Points (n, 3) mm where rays leave a surface from inside: sphere tracing (Hart 1996), then Newton's method.

    The gap is as steep along a ray as its slope leans to it; where that does not end, after a longer march.

    Parameters
    ----------
    gap
        Gap of the surface, which changes no faster than its distance.
    within
        Whether points (n, 3) mm at the base or above, from where rays start, are inside (n,).
    origin, rays
        See `Skin.hit`; a ray that does not pass the base is NaN.
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
    """Move points along their rays, first by so many steps of their gap, then by Newton's."""
    for step in range(march + _NEWTON if len(which) else 0):
        far, slope = gap(points[which])
        steep = (slope * unit[which]).sum(axis=1) if step >= march else np.ones(len(far))
        points[which] -= (far / np.maximum(steep, _GRAZING))[:, None] * unit[which]


def pass_base(within: Within, origin: FloatArray, rays: FloatArray) -> FloatArray:
    """Points (n, 3) mm where rays pass the base, or where they start above it; NaN where they are not inside there.

    The parameters are those of `trace_rays`.
    """
    points = np.broadcast_to(np.asarray(origin, float), rays.shape).copy()
    enter = np.where(points[:, 2] < 0, -points[:, 2] / np.where(rays[:, 2] > 0, rays[:, 2], np.nan), 0.0)
    points = points + enter[:, None] * rays
    points[~(within(points) & np.isfinite(points[:, 2]))] = np.nan
    return points


def leave_sphere(start: FloatArray, rays: FloatArray, radius: float) -> FloatArray:
    """How many times (n,) its length each ray goes to the farther crossing of ``|s + x d| = r``; NaN if it misses.

    Parameters
    ----------
    start, rays, radius
        Where rays start (n, 3) or (3,), seen from the sphere's centre, and where they go (n, 3); radius in mm.
    """
    along, square = (rays * start).sum(axis=1), (rays**2).sum(axis=1)
    root = along**2 - square * ((start**2).sum(axis=-1) - radius**2)
    return np.asarray((-along + np.sqrt(np.where(root >= 0, root, np.nan))) / square)
