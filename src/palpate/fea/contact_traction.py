"""Traction of a skin on an obstacle, from the equilibrium of its nodes.

The internal forces of a skin's outer surface are in equilibrium with the forces of contact, ``f_a = ∫ N_a t dA``. So
the traction ``t`` at a node is its force over the integral of its shape function on the deformed surface. Neither the
stiffness nor the history of contact is used.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray
from palpate.fea.nodal_stress import check_own_press, clamped_solid, state_of
from palpate.fea.press import Press
from palpate.mechanics import OuterSurface, Solid, State


class ContactTraction(NamedTuple):
    """Traction of a skin on an obstacle at the nodes of every increment of a press.

    Attributes
    ----------
    pressure
        (n, n_nodes) MPa, positive in contact; zero at nodes that are not on the outer surface, or fixed.
    shear
        (n, n_nodes, 3) MPa, tangential part, in the frame of the displacements.
    normal
        (n, n_nodes, 3) unit normal of the obstacle, into it.
    area
        (n, n_nodes) mm² of the deformed outer surface that belongs to each node of the mesh.
    """

    pressure: FloatArray
    shear: FloatArray
    normal: FloatArray
    area: FloatArray

    @property
    def traction(self) -> FloatArray:
        """(n, n_nodes, 3) MPa, of the skin on the obstacle, in the frame of the displacements."""
        return self.pressure[..., None] * self.normal + self.shear


def contact_traction(press: Press) -> ContactTraction:
    """Return the traction of the skin on the obstacle at every increment.

    Raises
    ------
    PalpateError
        As `check_own_press`.
    """
    check_own_press(press)
    solid, mesh = clamped_solid(press), press.mesh
    first = len(mesh.cells) - len(mesh.outer_faces)
    surface = OuterSurface(mesh.nodes, mesh.outer_faces, np.arange(first, len(mesh.cells)))
    path = press.obstacle.path(mesh)
    rows = []
    for depth, u in zip(press.depth, press.displacement, strict=True):
        traction, area = surface_traction(solid, surface, state_of(solid, u))
        traction[mesh.mirror, 0] = 0.0  # the reaction of the mirrored half
        traction[mesh.base] = 0.0  # the reaction of the mount
        normal = path(float(depth)).gap(mesh.nodes + u).normal
        pressure = np.einsum("ni,ni->n", traction, normal)
        rows.append((pressure, traction - pressure[:, None] * normal, normal, area))
    return ContactTraction(*(np.stack(each) for each in zip(*rows, strict=True)))


def surface_traction(solid: Solid, surface: OuterSurface, state: State) -> tuple[FloatArray, FloatArray]:
    """Return the traction (n, 3) MPa of a solid at the nodes of a surface, and their areas (n,) mm².

    The traction acts on the surroundings, and is zero at other nodes. On a plane of symmetry and at a mount, it
    includes their reactions.
    """
    residual = np.zeros(solid.nodes.size)
    solid.add_residual(state, residual)
    area = surface.node_areas(solid.nodes + state.u)
    traction = np.zeros_like(solid.nodes)
    np.divide(-residual.reshape(-1, 3), area[:, None], out=traction, where=area[:, None] > 0)
    return traction, area
