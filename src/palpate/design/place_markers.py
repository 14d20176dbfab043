"""Placement of markers on the inner surface of a skin."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design.markers import MarkerLayout
from palpate.design.points_file import read_points
from palpate.design.rings import ring_diameters
from palpate.design.skin import Skin
from palpate.design.spec import MarkerSpec


def place_markers(skin: Skin, spec: MarkerSpec) -> MarkerLayout:
    """Place the markers of `spec` on the inner surface, projected along the skin's axis.

    They are the apex and the rings, each from azimuth 0, the rows, or the points of the file. A marker outside the
    skin has no height (NaN) and is reported by `check_design`.

    Raises
    ------
    PalpateError
        If the file of a free layout cannot be read, does not lie on the skin, or has another number of markers than
        the spec; or if rows are requested for a skin with an apex, or rings for one without.

    Examples
    --------
    >>> from palpate.design import DomeSpec, build_skin
    >>> layout = place_markers(build_skin(DomeSpec(height=20)), MarkerSpec(count=7))
    >>> layout.positions[0].round(6).tolist(), len(layout)
    ([0.0, 0.0, 20.0], 7)
    """
    if spec.rows is not None or (skin.hole and spec.file is None):
        return MarkerLayout(positions=_rows(skin, spec), diameter=spec.diameter)
    if spec.file is None:
        diameters = spec.ring_diameters or ring_diameters(spec.count, skin.base_radius)
        return MarkerLayout(positions=_rings(skin, diameters), diameter=spec.diameter)
    positions = read_points(spec.file, skin)
    if "count" in spec.model_fields_set and spec.count != len(positions):
        raise PalpateError(
            f"{spec.file} has {len(positions)} markers, but count is {spec.count}.",
            "Leave count out; the file determines it.",
            code="marker-count-differs",
        )
    return MarkerLayout(positions=positions, diameter=spec.diameter)


def _rows(skin: Skin, spec: MarkerSpec) -> FloatArray:
    """Place rows symmetric about the middle of a tube's meridian, from the far end on."""
    if not skin.hole:
        raise PalpateError(
            f"{skin.name} has an apex; rows of markers need a tube.",
            "Give rings: ring_diameters.",
            code="rows-need-tube",
        )
    if spec.rows is None or spec.around is None or spec.pitch is None:
        raise PalpateError(
            f"{skin.name} has no apex; rings of markers need one.",
            "Give rows around it: markers: [{rows: 16, around: 16, pitch: 15 mm}], or a file.",
            code="rings-need-apex",
        )
    length = float(skin.arc_length(skin.marked(np.array([[1.0, 0.0]])))[0])
    place = (np.arange(spec.rows) - (spec.rows - 1) / 2) * spec.pitch
    if 2 * place[-1] >= length:
        raise PalpateError(
            f"{spec.rows} rows {spec.pitch:g} mm apart do not fit on a meridian of {length:.4g} mm.",
            f"Use a pitch below {length / max(spec.rows - 1, 1):.4g} mm, or fewer rows.",
            code="rows-too-long",
        )
    radius = skin.hole + (1 - skin.hole) * (0.5 + place / length)
    azimuth = 2.0 * np.pi * np.arange(spec.around) / spec.around
    way = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    return skin.marked((radius[:, None, None] * way).reshape(-1, 2))


def _rings(skin: Skin, diameters: Sequence[float]) -> FloatArray:
    counts = [1, *(6 * k for k in range(1, len(diameters) + 1))]
    rho = np.repeat([0.0, *diameters], counts) / 2.0
    azimuth = np.concatenate([2.0 * np.pi * np.arange(count) / count for count in counts])
    return skin.inner_point(rho, azimuth)
