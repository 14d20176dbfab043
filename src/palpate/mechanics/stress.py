"""Cauchy stress and stretch at the Gauss points of a solid."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, kernel
from palpate.material import isochoric
from palpate.mechanics.element import NODES, PRESSURES, Cells, Constitution, add_volumetric, deformation
from palpate.mechanics.solid import Solid, State


def cauchy_stress(solid: Solid, state: State) -> FloatArray:
    """Cauchy stress (n_cells, n_points, 6) MPa at the Gauss points, Voigt order xx, yy, zz, xy, yz, zx."""
    stress = np.empty((len(solid.cells.nodes), len(solid.cells.basis), 6))
    _cauchy(solid.cells, solid.constitution, state.u, state.p, stress)
    return stress


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises stress (...) of stresses (..., 6) in Voigt order."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(stress, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    result: FloatArray = np.sqrt(0.5 * normal + 3 * (xy**2 + yz**2 + zx**2))
    return result


def smallest_stretch(solid: Solid, state: State) -> tuple[float, FloatArray]:
    """Smallest principal stretch of all Gauss points, and its place (3,) mm in the undeformed solid."""
    cells = solid.cells
    F = np.eye(3) + np.einsum("eai,eqaj->eqij", state.u[cells.nodes], cells.gradient)
    stretch = np.linalg.svd(F, compute_uv=False)[..., -1]
    cell, point = np.unravel_index(stretch.argmin(), stretch.shape)
    place: FloatArray = solid.shape[point] @ solid.nodes[cells.nodes[cell]]
    return float(stretch[cell, point]), place


@kernel
def _cauchy(cells: Cells, law: Constitution, u: FloatArray, p: FloatArray, stress: FloatArray) -> None:
    """Write the stress at every Gauss point, whichever law `isochoric` is asked for."""
    F, g, ue = np.empty((3, 3)), np.empty((NODES, 3)), np.empty((NODES, 3))
    tau, c = np.empty(6), np.empty((6, 6))
    for e in range(len(cells.nodes)):
        for a in range(NODES):
            for i in range(3):
                ue[a, i] = u[cells.nodes[e, a], i]
        for q in range(len(cells.basis)):
            J = deformation(cells.gradient[e, q], ue, F, g)
            isochoric(law.code, law.parameters, F, tau, c)
            pressure = 0.0
            for k in range(PRESSURES):
                pressure += cells.basis[q, k] * p[e, k]
            add_volumetric(pressure * J, tau, c)
            for i in range(6):
                stress[e, q, i] = tau[i] / J
