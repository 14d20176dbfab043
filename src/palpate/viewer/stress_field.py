"""Von Mises stress at the nodes of every solved press of a dome."""

from __future__ import annotations

import numpy as np

from palpate.fea import Solid, nodal_stress, von_mises
from palpate.viewer.pressed_dome import Array32, PressedDome


def find_stress(pressed: PressedDome) -> Array32:
    """Von Mises Cauchy stress (d, t, n, 1) in MPa; zero where a press ended before, or at rest.

    It is interpolated between tilts like the displacement, which costs less than finding it again from there.
    """
    mesh = pressed.mesh
    solid = Solid(mesh.nodes, mesh.cells, pressed.material, np.zeros_like(mesh.nodes, bool))
    found = np.zeros((*pressed.displacement.shape[:3], 1), np.float32)
    for depth, tilt in np.argwhere(pressed.branch != ""):
        moved = pressed.displacement[depth, tilt].astype(float)
        if depth:
            found[depth, tilt, :, 0] = von_mises(nodal_stress(solid, moved))
    return found
