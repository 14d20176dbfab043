"""Stress at the nodes of a press."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.fea.press import Press
from palpate.mechanics import GAUSS, Solid, State, cauchy_stress, von_mises
from palpate.mesh import gauss_points, shape_hexahedron


def clamped_solid(press: Press) -> Solid:
    """The press's body with every node held: nothing is solved, so no pattern of a matrix is made."""
    mesh = press.mesh
    return Solid(mesh.nodes, mesh.cells, press.material, np.ones_like(mesh.nodes, bool), mesh.filling)


def nodal_von_mises(press: Press) -> FloatArray:
    """Von Mises Cauchy stress (n, n_nodes) in MPa at the nodes of every increment kept.

    Raises
    ------
    PalpateError
        If another solver made it: its elements have another pressure than our cells.
    """
    if press.solved_by != "palpate":
        raise PalpateError(
            f"A press solved by {press.solved_by} has no stress at nodes.",
            "Solve it with palpate.",
            code="press-no-nodal-stress",
        )
    solid = clamped_solid(press)
    return np.stack([von_mises(nodal_stress(solid, u)) for u in press.displacement])


def nodal_stress(solid: Solid, u: FloatArray) -> FloatArray:
    """Cauchy stress (n, 6) MPa at the nodes, order xx, yy, zz, xy, yz, zx, for a displacement (n, 3) mm.

    The pressure of each cell is that of equilibrium, ``p = K M^-1 ∫ q (J - 1) dV`` (`palpate.mechanics`); the 27
    Gauss points define a triquadratic field in each cell, taken at its nodes.
    """
    cells = solid.cells
    F = np.eye(3) + np.einsum("eai,eqaj->eqij", u[cells.nodes], cells.gradient)
    swelling = np.einsum("eq,qk,eq->ek", cells.weight, cells.basis, np.linalg.det(F) - 1.0)
    p = solid.bulk[:, None] * np.einsum("ekm,em->ek", cells.inverse_mass, swelling)
    at_points = cauchy_stress(solid, State(np.ascontiguousarray(u), p))
    to_nodes = np.linalg.inv(shape_hexahedron(gauss_points(GAUSS)[0])[0])
    at_nodes = np.einsum("aq,eqk->eak", to_nodes, at_points)
    total, count = np.zeros((len(solid.nodes), 6)), np.zeros(len(solid.nodes))
    np.add.at(total, cells.nodes, at_nodes)
    np.add.at(count, cells.nodes, 1.0)
    mean: FloatArray = total / count[:, None]
    return mean
