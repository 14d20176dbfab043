"""Stress at the nodes of a press."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.fea.press import Press
from palpate.mechanics import GAUSS, Solid, State, cauchy_stress, von_mises
from palpate.mesh import gauss_points, shape_hexahedron


def clamped_solid(press: Press) -> Solid:
    """Return the press's body with every node fixed: nothing is solved, so no matrix pattern is needed."""
    mesh = press.mesh
    return Solid(mesh.nodes, mesh.cells, press.material, np.ones_like(mesh.nodes, bool), mesh.filling)


def check_own_press(press: Press) -> None:
    """Raise a `PalpateError` if another solver made a press, whose elements define pressure differently."""
    if press.solved_by != "palpate":
        raise PalpateError(
            f"A press solved by {press.solved_by} has no stress at nodes.",
            "Solve it with palpate.",
            code="press-no-nodal-stress",
        )


def nodal_von_mises(press: Press) -> FloatArray:
    """Return the von Mises Cauchy stress (n, n_nodes) in MPa at the nodes of every increment.

    Raises
    ------
    PalpateError
        As `check_own_press`.
    """
    check_own_press(press)
    solid = clamped_solid(press)
    return np.stack([von_mises(nodal_stress(solid, u)) for u in press.displacement])


def state_of(solid: Solid, u: FloatArray) -> State:
    """Return the state of a displacement (n, 3) mm, with the pressure ``p = K M^-1 ∫ q (J - 1) dV``."""
    cells = solid.cells
    F = np.eye(3) + np.einsum("eai,eqaj->eqij", u[cells.nodes], cells.gradient)
    swelling = np.einsum("eq,qk,eq->ek", cells.weight, cells.basis, np.linalg.det(F) - 1.0)
    p = solid.bulk[:, None] * np.einsum("ekm,em->ek", cells.inverse_mass, swelling)
    return State(np.ascontiguousarray(u), p)


def nodal_stress(solid: Solid, u: FloatArray) -> FloatArray:
    """Return the Cauchy stress (n, 6) MPa at the nodes, xx, yy, zz, xy, yz, zx.

    The 27 Gauss points define a triquadratic field in each cell, evaluated at its nodes and averaged over cells.
    """
    cells = solid.cells
    at_points = cauchy_stress(solid, state_of(solid, u))
    to_nodes = np.linalg.inv(shape_hexahedron(gauss_points(GAUSS)[0])[0])
    at_nodes = np.einsum("aq,eqk->eak", to_nodes, at_points)
    total, count = np.zeros((len(solid.nodes), 6)), np.zeros(len(solid.nodes))
    np.add.at(total, cells.nodes, at_nodes)
    np.add.at(count, cells.nodes, 1.0)
    mean: FloatArray = total / count[:, None]
    return mean
