"""The orientation mark: one more dot, outside the others, that breaks the symmetry of the rings.

Rings of 6, 12, 18, … dots that all begin at azimuth 0 look the same turned by 60° and in a mirror through every 30°.
A dot at 15° lies as far from all of those as it can. Rows about a barrel turn by the step between their dots,
so a quarter of it does the same there, between the last row and the rim.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.design.markers import MarkerLayout
from palpate.design.skin import Skin

AZIMUTH_DEG = 15.0
_CLEARANCE = 1.4
"""Distance from the outermost dots, over the diameter of a dot, where the dome has room."""


def place_orientation_mark(skin: Skin, layout: MarkerLayout) -> FloatArray:
    """Place the mark beyond the outermost dots; where there is less room, half way to where the skin is widest there.

    Of a barrel the outermost are those nearest to the rim, and half way is to the rim.

    Returns
    -------
    ndarray
        (3,) mm, centre of the mark.

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
