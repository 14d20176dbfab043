"""Where rays leave a skin: by its distance, or anything that grows no faster, first; then by Newton's method."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.core import BoolArray, FloatArray

Gap = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""From points (n, 3) mm to how far outside the surface they are (n,), and the slope (n, 3) of that."""
Within = Callable[[FloatArray], BoolArray]

_FIRST, _NEWTON, _MARCH = 4, 8, 60
"""Steps along a ray, each as long as the gap: before Newton's, of these, and where they fail."""
_GRAZING, _HIT_MM = 0.05, 1e-9
"""Least slope of the gap along a ray that a step is taken by, and gap at which a ray has hit."""


def trace_rays(gap: Gap, within: Within, origin: FloatArray, rays: FloatArray) -> FloatArray:
    """Points (n, 3) mm where rays leave a surface from inside: sphere tracing (Hart 1996), then Newton's method.

    The gap is as steep along a ray as its slope leans to it; where that does not end, by marching alone.

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
    points = np.broadcast_to(np.asarray(origin, float), rays.shape).copy()
    enter = np.where(points[:, 2] < 0, -points[:, 2] / np.where(unit[:, 2] > 0, unit[:, 2], np.nan), 0.0)
    points = points + enter[:, None] * unit
    points[~(within(points) & np.isfinite(points[:, 2]))] = np.nan
    found = np.isfinite(points[:, 0])
    start = points.copy()
    for step in range(_FIRST + _NEWTON):
        far, slope = gap(points[found])
        steep = (slope * unit[found]).sum(axis=1) if step >= _FIRST else np.ones(len(far))
        points[found] -= (far / np.maximum(steep, _GRAZING))[:, None] * unit[found]
    astray = np.flatnonzero(found)[np.abs(gap(points[found])[0]) > _HIT_MM]
    points[astray] = start[astray]
    for _ in range(_MARCH if len(astray) else 0):
        points[astray] -= gap(points[astray])[0][:, None] * unit[astray]
    return points
