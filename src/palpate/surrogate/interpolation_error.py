"""Interpolation error of a twin, from presses between those that it contains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate.design import rotation_vector
from palpate.fea import Branch, Press
from palpate.surrogate.tilt_runs import SAME_DEPTH_MM
from palpate.surrogate.twin import Twin

_CIRCLES, _AROUND = 12, 24
"""Number of circles of the inner surface, and of points on each, at which it is evaluated. By hand."""
_OUTERMOST = 0.9
"""Radius of the outermost circle over the maximum radius. By hand."""


def measure_interpolation_error(twin: Twin, presses: Sequence[Press]) -> float:
    """Return the RMS distance, mm, between points of pressed skins and their prediction by a twin.

    Parameters
    ----------
    twin
        Twin of the pressed skin.
    presses
        Presses at poses and frictions that it does not contain; of each, all increments of the flat branch.

    Returns
    -------
    float
        Over all points and increments; nan without any.
    """
    skin, squares = twin.skin, []
    radius = _OUTERMOST * skin.widest[0] * np.sqrt((np.arange(_CIRCLES) + 0.5) / _CIRCLES)
    azimuth = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    points = skin.inner_point(np.repeat(radius, _AROUND), np.tile(azimuth, _CIRCLES))
    dots = twin.with_markers(points)
    for press in presses:
        turn = np.radians(press.obstacle.turn_deg)
        slip = 1.0 / press.obstacle.friction if press.obstacle.friction > 0 else float(twin.inverse_frictions[0])
        deepest = min(float(twin.depths_mm[-1]) + SAME_DEPTH_MM, press.jump_depth)
        kept = (press.depth > 0) & (press.depth <= deepest) & (press.branch == str(Branch.FLAT))
        for depth, true in zip(press.depth[kept], press.positions(points)[kept], strict=True):
            pose = np.append(rotation_vector(press.obstacle.radial, turn), depth)
            squares.append(((dots.evaluate(pose, slip).positions - true) ** 2).sum(axis=1))
    return float(np.sqrt(np.mean(squares))) if squares else float("nan")
