"""Derivatives of a press compared with symmetry, scaling, and differences of presses."""

from __future__ import annotations

import numpy as np

from palpate.design import DomeSpec, build_skin
from palpate.fea import WallSpec, solve_press
from palpate.mechanics import SolverSpec
from palpate.mesh import Mesh, MeshSpec, centre_mesh, mesh_skin, reshape_mesh
from palpate.verify.case import Row, below, compare
from palpate.verify.properties import SILICONE

_SKIN = DomeSpec(height=20, thickness=2)
_WALL = WallSpec(tilt_deg=5, depth=3.2, contact="frictionless")
_STEPS = {"tilt_deg": 0.02, "thickness": 0.005, "height": 0.02, "base_radius": 0.02}
"""Half the difference of whole presses, degrees and mm. By hand."""


def derivatives() -> list[Row]:
    """Compare derivatives of a frictionless press: rotated force, Euler's theorem, finite differences."""
    constants = SILICONE.key_data()["constants"]
    solver = SolverSpec(tolerance=1e-8, derivatives=(*_STEPS, "across_deg", *constants))
    mesh = _mesh(_SKIN)
    press = solve_press(mesh, SILICONE, _WALL, solver)
    across = press.derivative("across_deg").force[-1]
    turned = np.cross([0.0, 0.0, 1.0], press.force[-1]) / _WALL.tilt_deg
    stiffer = sum(value * press.derivative(name).force[-1] for name, value in constants.items())
    rows = [
        compare("force by the tilt across: that turned about the axis, N/°", across[0], turned[0], 1e-6),
        compare("all constants by one factor: the force, N", stiffer[2], press.force[-1, 2], 1e-5),
    ]
    for name, by in _STEPS.items():
        sides = []
        for step in (by, -by):
            wall = _WALL.model_copy(update={name: _WALL.tilt_deg + step}) if name == "tilt_deg" else _WALL
            skin = _SKIN if name == "tilt_deg" else _SKIN.model_copy(update={name: getattr(_SKIN, name) + step})
            sides.append(solve_press(reshape_mesh(mesh, build_skin(skin)), SILICONE, wall, solver).displacement[-1])
        expected = (sides[0] - sides[1]) / (2 * by)
        miss = np.linalg.norm(press.derivative(name).displacement[-1] - expected) / np.linalg.norm(expected)
        rows.append(below(f"field by {name} against two presses, share of its norm", float(miss), 5e-3))
    return rows


def _mesh(skin: DomeSpec) -> Mesh:
    mesh = mesh_skin(build_skin(skin), MeshSpec(cells=12))
    return centre_mesh(mesh, _WALL.at_first_contact(mesh)[1])
