"""Presses of a skin with the mirrors x → −x and y → −y: sorted by tilt and azimuth, and mirrored to all azimuths.

With M the mirror x → −x, a marker at p moves by

    u(p; rx, ry) = M u(M p; rx, −ry)

for the axis of a rotation is no arrow: its part across the mirror stays, that along the mirror turns round. So
azimuth α becomes −α, in the mirror y → −y it becomes 180° − α, and in both α + 180°.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from palpate.core import FloatArray, PalpateError
from palpate.fea import Press
from palpate.twin.tilt_runs import SAME_DEPTH_MM

MIRRORS = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]])
"""(4, 3) factors of x, y and z: nothing, x → −x, y → −y, and both."""
_DECIMALS = 6
"""Of an azimuth in degrees."""
Table = Mapping[tuple[float, float], Press]
"""Presses by tilt and azimuth in degrees."""


def sort_presses(presses: Sequence[Press]) -> tuple[Table, tuple[float, ...]]:
    """Presses by tilt and azimuth, the straight one at every azimuth, and the azimuths in degrees.

    Raises
    ------
    PalpateError
        If the obstacle does not tilt, the azimuths are not 0 to 90° in equal steps, or a press is missing.
    """
    if not all(press.obstacle.pose_space.is_tilt for press in presses):
        raise PalpateError(
            "Presses of a skin that is no body of revolution are interpolated under flat walls alone.",
            "Read single presses of other obstacles.",
            code="azimuths-need-flat-wall",
        )
    table: dict[tuple[float, float], Press] = {}
    azimuths = _azimuths(presses)
    for press in presses:
        tilt, azimuth = press.obstacle.radial, round(press.obstacle.turn_deg, _DECIMALS)
        for place in [(tilt, azimuth)] if tilt > 0 else [(tilt, each) for each in azimuths]:
            if place in table:
                raise PalpateError(
                    f"The tilt {tilt:g}° at {place[1]:g}° was given twice.",
                    "Keep one press a pose.",
                    code="tilt-twice",
                )
            table[place] = press
    tilts = sorted({tilt for tilt, _ in table})
    missing = [f"{tilt:g}° at {each:g}°" for tilt in tilts for each in azimuths if (tilt, each) not in table]
    if missing:
        raise PalpateError(
            f"Presses are missing: the tilt {', '.join(missing)}.",
            "Press every tilt at every one of the azimuths.",
            code="presses-missing",
        )
    return table, azimuths


def _azimuths(presses: Sequence[Press]) -> tuple[float, ...]:
    found = tuple(
        sorted({round(press.obstacle.turn_deg, _DECIMALS) for press in presses if press.obstacle.radial > 0})
    )
    even = np.linspace(0.0, 90.0, len(found))
    if len(found) < 2 or not np.allclose(found, even, atol=10.0**-_DECIMALS):
        given = ", ".join(f"{each:g}" for each in found)
        raise PalpateError(
            f"Presses at the azimuths {given or '(none)'}° do not tell the others of {presses[0].mesh.skin.name}.",
            "Press every tilt from 0 to 90° in equal steps, such as 0, 30, 60 and 90°.",
            code="azimuths-incomplete",
        )
    return found


def mirror_points(press: Press, points: FloatArray) -> FloatArray:
    """Displacements (i, 4, m, 3) mm of points (m, 3) mm of the inner surface in the images of a press, mirrored."""
    moved = press.displacement_at((MIRRORS[:, None] * points).reshape(-1, 3))
    return np.asarray(moved.reshape(len(moved), 4, *points.shape) * MIRRORS[:, None])


def at_depths(press: Press, values: FloatArray, depths_mm: FloatArray) -> FloatArray:
    """Values (i, 4, …) of a press's images at any depths (d,) mm, as (4, d, …).

    By the cubic spline through the images on the way down; as at rest before first touch, NaN beyond the last image.
    """
    down = int(np.argmax(press.depth)) + 1
    seen = np.full((len(depths_mm), *values.shape[1:]), np.nan)
    reached = depths_mm <= press.depth[down - 1] + SAME_DEPTH_MM
    seen[reached] = CubicSpline(press.depth[:down], values[:down])(np.maximum(depths_mm[reached], 0.0))
    return np.moveaxis(seen, 1, 0)


def all_azimuths(quarter: Sequence[FloatArray]) -> FloatArray:
    """Values (d, n, …) at n azimuths around from those (4, d, …) of presses at 0 to 90° and their mirror images."""
    half = 2 * (len(quarter) - 1)
    around = np.empty((quarter[0].shape[1], 2 * half, *quarter[0].shape[2:]))
    for number, seen in enumerate(quarter):
        places = (number, -number, half - number, half + number)
        for place in {place % (2 * half) for place in places}:
            same = [k for k in range(4) if places[k] % (2 * half) == place]
            around[:, place] = seen[same].mean(axis=0)
    return around
