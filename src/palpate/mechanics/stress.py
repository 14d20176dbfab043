"""Cauchy stress and stretch at the Gauss points of a solid."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, kernel
from palpate.mechanics.element import PRESSURES, Cells, Response, add_volumetric, determinant
from palpate.mechanics.solid import Solid, State


def cauchy_stress(solid: Solid, state: State) -> FloatArray:
    """Return the Cauchy stress (n_cells, n_points, 6) MPa at the Gauss points; NaN if a cell is inverted.

    Voigt order xx, yy, zz, xy, yz, zx.
    """
    stress = np.full((*solid.cells.weight.shape, 6), np.nan)
    response = solid.respond(state)
    if response is not None:
        _cauchy(solid.cells, response, state.p, stress)
    return stress


def von_mises(stress: FloatArray) -> FloatArray:
    """Return the von Mises stress (...) of stresses (..., 6) in Voigt order."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(stress, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    result: FloatArray = np.sqrt(0.5 * normal + 3 * (xy**2 + yz**2 + zx**2))
    return result


def smallest_stretch(solid: Solid, state: State) -> tuple[float, FloatArray]:
    """Return the smallest principal stretch of all Gauss points, and its undeformed place (3,) mm."""
    cells = solid.cells
    F = np.eye(3) + np.einsum("eai,eqaj->eqij", state.u[cells.nodes], cells.gradient)
    stretch = np.linalg.svd(F, compute_uv=False)[..., -1]
    cell, point = np.unravel_index(stretch.argmin(), stretch.shape)
    place: FloatArray = solid.shape[point] @ solid.nodes[cells.nodes[cell]]
    return float(stretch[cell, point]), place


@kernel
def _cauchy(cells: Cells, response: Response, p: FloatArray, stress: FloatArray) -> None:
    """Write the stress at every Gauss point."""
    tau, c = np.empty(6), np.empty((6, 6))
    for e in range(len(cells.nodes)):
        for q in range(len(cells.basis)):
            J = determinant(response.F[e, q])
            tau[:] = response.tau[e, q]
            pressure = 0.0
            for k in range(PRESSURES):
                pressure += cells.basis[q, k] * p[e, k]
            add_volumetric(pressure * J, tau, c)
            for i in range(6):
                stress[e, q, i] = tau[i] / J
