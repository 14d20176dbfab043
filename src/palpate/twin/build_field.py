"""From solved presses to the markers for any pose: the interpolation that a skin's symmetry allows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import MarkerLayout, Symmetry
from palpate.fea import Press
from palpate.twin.field import build_revolved_field
from palpate.twin.marker_field import MarkerField
from palpate.twin.tilt_runs import shared_depths
from palpate.twin.turned_field import build_two_mirror_field


def build_field(presses: Sequence[Press], markers: MarkerLayout, depths_mm: FloatArray | None = None) -> MarkerField:
    """Interpolate presses of one skin, which differ by the pose of the obstacle alone.

    Parameters
    ----------
    presses
        At least one, of a body of revolution one a tilt of the wall, or offset of the obstacle; of a skin with two
        mirrors, such as a pad, one at every azimuth of each tilt (see `palpate.twin.turned_series`). The images must
        be the same distance apart.
    markers
        Layout of undeformed markers on the inner surface.
    depths_mm
        (d,) rising; without them, those of the images after rest.

    Returns
    -------
    MarkerField
        Positions of the markers for every pose that the presses support.

    Raises
    ------
    PalpateError
        If there is no press, a pose appears twice or is missing, the image steps differ, a marker is not on the skin,
        or nothing leaves the skin as it is.
    """
    symmetries = {press.mesh.skin.symmetry for press in presses}
    if Symmetry.NONE in symmetries:
        name = next(press.mesh.skin.name for press in presses if press.mesh.skin.symmetry is Symmetry.NONE)
        raise PalpateError(
            f"{name} is no body of revolution and has no mirrors: one press does not serve other azimuths.",
            "Press every azimuth and read single presses; images of such a skin are not interpolated.",
            code="skin-no-symmetry",
        )
    if len({press.obstacle.pose_space for press in presses}) > 1:
        raise PalpateError(
            "The presses are of obstacles with different poses.",
            "Give presses of one obstacle.",
            code="presses-obstacles-differ",
        )
    outside = int((~np.isfinite(markers.positions).all(axis=1)).sum())
    if outside:
        raise PalpateError(
            f"{outside} markers lie outside the dome.",
            "Leave them out, or use smaller rings.",
            code="markers-outside-skin",
        )
    if Symmetry.MIRRORED in symmetries:
        return build_two_mirror_field(presses, markers, depths_mm)
    return build_revolved_field(presses, markers, shared_depths(presses) if depths_mm is None else depths_mm)
