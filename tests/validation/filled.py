"""A filled hemisphere on its rigid window under a plate, as the product presses it, against an axisymmetric program.

Wall and gel are one silicone, so that it is a solid half ball bonded to the window (`validation.half_sphere`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from palpate.design import DomeSpec
from palpate.fea import WallSpec, solve_press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.verify.case import Row, compare
from palpate.verify.rubber import NEO_HOOKE
from validation.half_sphere import press_half_ball

_INNER, _WALL, _STEP = 15.0, 1.0, 0.8
_CELLS = 8
_CLOSE = 2e-2


def filled_hemisphere(*, bonded: bool = True) -> list[Row]:
    """Force, energy and sinking of the apex's marker at depths to a fifth of the radius.

    Parameters
    ----------
    bonded
        Whether the half ball that ours is held to is bonded to its base; it is not in a control that must not pass.
    """
    radius = _INNER + _WALL
    skin = DomeSpec(height=_INNER, base_radius=_INNER, thickness=_WALL).build()
    mesh = mesh_skin(skin, MeshSpec(cells=_CELLS, filled=True))
    wall = WallSpec(contact="frictionless", depth=0.2 * radius, depth_step=_STEP)
    press = solve_press(mesh, replace(NEO_HOOKE, gel=NEO_HOOKE), wall)
    depth = press.depth[1:]
    marker = np.array([[0.0, 0.0, _INNER]])
    sunk = -press.displacement_at(marker)[1:, 0, 2]
    c10 = 0.5 * NEO_HOOKE.law.shear_modulus
    theirs = press_half_ball(list(depth / radius), c10, [_INNER / radius], bonded=bonded)
    at = [f"d/R = {value:.2g}" for value in depth / radius]
    return [
        compare("force, N", press.force[1:, 2], [radius**2 * item.force for item in theirs], _CLOSE, at),
        compare("energy, mJ", press.energy[1:], [radius**3 * item.energy for item in theirs], _CLOSE, at),
        compare("sinking of the apex, mm", sunk, [radius * float(item.sunk[0]) for item in theirs], _CLOSE, at),
    ]
