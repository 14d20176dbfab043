"""Orientation mark: an additional marker outside the layout that breaks the symmetry of the rings.

Rings of 6, 12, 18, … markers that all begin at azimuth 0 are symmetric under rotation by 60° and mirroring every 30°.
A marker at 15° is as far from all symmetry planes as possible. Rows around a barrel are symmetric under rotation by
their marker step, so the mark is at a quarter of it, between the last row and the rim.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.design.markers import MarkerLayout
from palpate.design.skin import Skin

AZIMUTH_DEG = 15.0
"""Azimuth of the mark, degrees: on no mirror plane of the presets."""
_CLEARANCE = 1.4
"""Distance from the outermost markers, over the diameter of a marker, if the skin is large enough.
By hand."""


def place_orientation_mark(skin: Skin, layout: MarkerLayout) -> FloatArray:
    """Return the centre (3,) mm of the mark, outside the outermost markers.

    It is at most halfway to the skin's maximum radius there. On a barrel the outermost markers are those nearest to
    the rim, and the limit is halfway to the rim.

    Examples
    --------
    >>> from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
    >>> skin = build_skin(DomeSpec())
    >>> mark = place_orientation_mark(skin, place_markers(skin, MarkerSpec(count=37)))
    >>> round(float(np.degrees(np.arctan2(mark[1], mark[0]))), 6)
    15.0
    """
    if skin.hole:
        return _neighbour_rows(skin, layout)
    rho = float(np.hypot(*layout.positions[layout.on_dome, :2].T).max())
    azimuth = np.radians(AZIMUTH_DEG)
    outermost = min(rho + _CLEARANCE * layout.diameter, (rho + float(skin.reach(azimuth))) / 2)
    point: FloatArray = skin.inner_point(outermost, azimuth)
    return point


def _neighbour_rows(skin: Skin, layout: MarkerLayout) -> FloatArray:
    room = skin.distance_to_rim(layout.positions)
    last = np.flatnonzero(room < room.min() + layout.diameter / 2)
    beyond = min(_CLEARANCE * layout.diameter, float(room.min()) / 2)
    length = float(skin.arc_length(skin.marked(np.array([[1.0, 0.0]])))[0])
    along = skin.hole + (1 - skin.hole) * (1 - (float(room.min()) - beyond) / length)
    azimuth = np.arctan2(*layout.positions[last[0], 1::-1]) + np.pi / 2 / len(last)
    point: FloatArray = skin.marked(along * np.array([[np.cos(azimuth), np.sin(azimuth)]]))[0]
    return point
