"""Mechanical model of a skin: a body on its clamped base, and an obstacle on its outer surface."""

from __future__ import annotations

import numpy as np

from palpate.core import PalpateError
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mechanics import ContactLaw, ContactLoading, OuterSurface, Solid, SolverSpec
from palpate.mesh import Mesh

POINTS_PER_SIDE = 6
"""Gauss points along each side of a contact face; with four, the force oscillates as the patch grows."""


def clamp_skin(mesh: Mesh, material: Material, *, across: bool = False) -> Solid:
    """Return the skin on its clamped base; a half skin is symmetric, or with `across` antisymmetric."""
    fixed = np.zeros((len(mesh.nodes), 3), bool)
    fixed[mesh.base] = True
    fixed[mesh.mirror] |= np.array([not across, across, across])
    if material.gel is not None and not mesh.filling:
        raise PalpateError(
            f"The material has a filling of {material.gel.name}, but the mesh is hollow.",
            "Mesh the filling too: MeshSpec(filled=True).",
            code="mesh-not-filled",
        )
    return Solid(mesh.nodes, mesh.cells, material, fixed, mesh.filling)


def load_surface(
    solver: SolverSpec, mesh: Mesh, material: Material, obstacle: ObstacleSpec, points_per_side: int = POINTS_PER_SIDE
) -> ContactLoading:
    """Return the loading of the outer surface by an obstacle, with Gauss points along each side of a face."""
    first = len(mesh.cells) - len(mesh.outer_faces)
    surface = OuterSurface(mesh.nodes, mesh.outer_faces, np.arange(first, len(mesh.cells)), points_per_side)
    stiffness = solver.penalty_ratio * material.young_modulus / mesh.skin.thickness
    law = ContactLaw(
        stiffness=stiffness,
        width=solver.smoothing_ratio * mesh.skin.thickness,
        tangential_stiffness=solver.tangential_ratio * stiffness,
        friction=obstacle.friction,
    )
    return ContactLoading(
        mesh.nodes,
        surface,
        law,
        obstacle.path(mesh),
        aside=obstacle.moves_laterally,
        way=obstacle.approach_axis(mesh),
    )
