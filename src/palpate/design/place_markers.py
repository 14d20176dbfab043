"""From a spec to markers on the inner surface of a dome."""

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
    """Place the markers of `spec` on the inner surface, carried there along the dome's axis.

    Parameters
    ----------
    skin
        The skin.
    spec
        Rings or a free layout. Every ring starts at azimuth 0.

    Returns
    -------
    MarkerLayout
        The apex and the rings, or the points of the file; a marker outside the dome has no height (NaN) and
        is reported by `check_design`.

    Raises
    ------
    PalpateError
        If the file of a free layout cannot be read, does not lie on the dome, or has another number of
        markers than the spec asks for.

    Examples
    --------
    >>> from palpate.design import DomeSpec, build_skin
    >>> layout = place_markers(build_skin(DomeSpec(height=20)), MarkerSpec(count=7))
    >>> layout.positions[0].round(6).tolist(), len(layout)
    ([0.0, 0.0, 20.0], 7)
    """
    if spec.file is None:
        diameters = spec.ring_diameters or ring_diameters(spec.count, skin.base_radius)
        return MarkerLayout(positions=_rings(skin, diameters), diameter=spec.diameter)
    positions = read_points(spec.file, skin)
    if "count" in spec.model_fields_set and spec.count != len(positions):
        raise PalpateError(
            f"{spec.file} has {len(positions)} markers, but count is {spec.count}.",
            "Leave count out: the file gives it.",
        )
    return MarkerLayout(positions=positions, diameter=spec.diameter)


def _rings(skin: Skin, diameters: Sequence[float]) -> FloatArray:
    counts = [1, *(6 * k for k in range(1, len(diameters) + 1))]
    rho = np.repeat([0.0, *diameters], counts) / 2.0
    azimuth = np.concatenate([2.0 * np.pi * np.arange(count) / count for count in counts])
    return skin.inner_point(rho, azimuth)
