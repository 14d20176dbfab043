"""Interpolation of solved presses for any pose, by the symmetry of the skin."""

from __future__ import annotations

from collections.abc import Sequence

from palpate.core import FloatArray, PalpateError
from palpate.design import MarkerLayout, Symmetry
from palpate.fea import Press
from palpate.surrogate.press_field import PressField
from palpate.surrogate.revolved_field import RevolvedField
from palpate.surrogate.two_mirror_field import TwoMirrorField


def build_field(
    presses: Sequence[Press], markers: MarkerLayout | None = None, depths_mm: FloatArray | None = None
) -> PressField:
    """Interpolate presses of one skin that differ by the pose of the obstacle only.

    Parameters
    ----------
    presses
        At least one, of a body of revolution one a tilt of the wall, or offset of the obstacle; of a skin with two
        mirrors, such as a pad, one at every azimuth of each tilt (see `palpate.surrogate.two_mirror_field`). All
        have one depth step.
    markers
        Layout of undeformed markers on the inner surface; without it, forces and nodal fields alone.
    depths_mm
        (d,) ascending; by default those of the increments after rest.

    Returns
    -------
    PressField
        For every pose that the presses support.

    Raises
    ------
    PalpateError
        If there is no press, a pose appears twice or is missing, the depth steps differ, a marker is not on the skin,
        or the skin has no usable symmetry.
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
    symmetry = TwoMirrorField if Symmetry.MIRRORED in symmetries else RevolvedField
    field = symmetry.of(presses, depths_mm)
    return field if markers is None else field.with_markers(markers)
