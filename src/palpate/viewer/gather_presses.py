"""Gather the solved presses of one skin, so that it can be drawn at any pose of the wall."""

from __future__ import annotations

from collections.abc import Sequence

from palpate.core import PalpateError
from palpate.design import Symmetry
from palpate.fea import Press
from palpate.mesh import mesh_skin
from palpate.viewer.pressed_skin import PressedSkin
from palpate.viewer.revolved_presses import gather_revolved
from palpate.viewer.turned_presses import build_two_mirror_skin


def build_pressed_skin(presses: Sequence[Press]) -> PressedSkin:
    """Gather the presses of one skin for interpolation.

    Parameters
    ----------
    presses
        At least one, of one mesh and image step: of half a skin of revolution one a tilt, of a skin with two mirrors
        one at every azimuth of each tilt.

    Raises
    ------
    PalpateError
        If there is none, they differ by more than the pose of a wall, or the skin has neither symmetry or, of
        revolution, was meshed whole.
    """
    if not presses:
        raise PalpateError("There is no press to show.", "Run the study first.", code="presses-none")
    first = presses[0]
    skin, spec = first.mesh.skin, first.mesh.spec.model_copy(update={"whole": False})
    if not first.obstacle.pose_space.is_tilt:
        raise PalpateError(
            f"Presses by other than walls are not drawn: {first.obstacle.label}.",
            "Write single presses for ParaView: `palpate press --export FOLDER`.",
            code="obstacle-not-drawn",
        )
    if any(
        press.mesh.spec.model_copy(update={"whole": False}) != spec or press.mesh.skin != skin for press in presses
    ):
        raise PalpateError(
            "The presses are not of one skin and mesh.",
            "Give presses that differ by the pose alone.",
            code="presses-designs-differ",
        )
    if skin.symmetry is Symmetry.NONE:
        raise PalpateError(
            f"{skin.name} has no symmetry: its presses are not interpolated.",
            "Write single presses for ParaView: `palpate press --export FOLDER`.",
            code="skin-no-symmetry",
        )
    if skin.symmetry is Symmetry.MIRRORED:
        return build_two_mirror_skin(presses, mesh_skin(skin, spec.model_copy(update={"whole": True})))
    if any(press.mesh.spec.whole for press in presses):
        raise PalpateError(
            "Presses of a whole dome are not drawn.",
            "Press half of it: mesh: {whole: false}.",
            code="mesh-half-needed",
        )
    return gather_revolved(presses, mesh_skin(skin, spec))
