"""A skin as mechanics sees it: a body on its clamped base, and an obstacle that comes down on its outer surface."""

from __future__ import annotations

import numpy as np

from palpate.core import PalpateError
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mechanics import ContactLaw, ContactLoading, OuterSurface, Solid, SolverSpec
from palpate.mesh import Mesh

POINTS_PER_SIDE = 6
"""Gauss points along each side of a face in contact: with four the force ripples as the patch grows past them."""


def clamp_skin(mesh: Mesh, material: Material, *, across: bool = False) -> Solid:
    """The skin on its clamped base; half of it symmetric about its mirror plane, or antisymmetric: `across` it."""
    fixed = np.zeros((len(mesh.nodes), 3), bool)
    fixed[mesh.base] = True
    fixed[mesh.mirror] |= np.array([not across, across, across])
    if material.gel is not None and not mesh.filling:
        raise PalpateError(
            f"The material fills the skin with {material.gel.name}, and the mesh is hollow.",
            "Mesh the filling too: MeshSpec(filled=True).",
            code="mesh-not-filled",
        )
    return Solid(mesh.nodes, mesh.cells, material, fixed, mesh.filling)


def load_surface(
    solver: SolverSpec, mesh: Mesh, material: Material, obstacle: ObstacleSpec, points_per_side: int = POINTS_PER_SIDE
) -> ContactLoading:
    """The obstacle that comes down on the outer surface from first touch on; Gauss points along a face's side."""
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
