"""The element: 27-node hexahedra with a discontinuous linear pressure (Q2/P1), in compiled kernels.

The energy of a cell is that of the perturbed Lagrangian (Simo, Taylor & Pister 1985; Boffi, Brezzi & Fortin 2013,
section 8.6: the pair is inf-sup stable)

    E(u, p) = ∫ W_iso(F) + p (J - 1) - p² / (2K) dV,   p = p0 + p1 xi + p2 eta + p3 zeta in each cell.

Newton's method linearises both fields; the four pressures of a cell are condensed before assembly:

    (K_uu + K C^T M^-1 C) du = -(r_u + K C^T M^-1 r_p),    dp = K M^-1 (C du + r_p),
    C = ∫ q J g dV,   r_p = ∫ q (J - 1 - p/K) dV,   M = ∫ q q dV,   g = F^-T grad N.

`u` and `p` are independent during the iteration, so a rotation predicted to first order causes no spurious pressure,
and the number of iterations does not grow with the bulk modulus.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray, IntArray, kernel

NODES, DOFS, PRESSURES = 27, 3 * 27, 4
"""Nodes, degrees of freedom and pressures of a cell: Q2/P1."""


class Cells(NamedTuple):
    """Constant tables of all cells.

    Attributes
    ----------
    nodes
        (n_cells, 27) node numbers.
    gradient
        (n_cells, n_points, 27, 3) referential shape gradients at the Gauss points, 1/mm.
    weight
        (n_cells, n_points) mm³.
    basis
        (n_points, 4) pressure basis.
    inverse_mass
        (n_cells, 4, 4) inverse of the pressure mass matrix, 1/mm³.
    place
        (n_cells, 3321) index into the values of the sparse matrix, for every entry of a cell's upper triangle; -1 for
        entries that are left out.
    """

    nodes: IntArray
    gradient: FloatArray
    weight: FloatArray
    basis: FloatArray
    inverse_mass: FloatArray
    place: IntArray


class Response(NamedTuple):
    """Response of a law at the Gauss points.

    Attributes
    ----------
    F
        (n_cells, n_points, 3, 3) deformation gradient.
    energy
        (n_cells, n_points) MPa isochoric energy per undeformed volume.
    tau
        (n_cells, n_points, 6) MPa isochoric Kirchhoff stress, Voigt order xx, yy, zz, xy, yz, zx.
    c
        (n_cells, n_points, 6, 6) MPa its spatial tangent.
    """

    F: FloatArray
    energy: FloatArray
    tau: FloatArray
    c: FloatArray


class System(NamedTuple):
    """Linear system under assembly: values (nnz,) N/mm of the sparse upper triangle, residual (3 n,) N."""

    data: FloatArray
    residual: FloatArray


class Condensed(NamedTuple):
    """Inputs of `recover_pressure`: C (n_cells, 4, 81) mm² and r_p (n_cells, 4) mm³."""

    coupling: FloatArray
    volume_residual: FloatArray


@kernel
def deformation_gradient(gradient: FloatArray, u: FloatArray, F: FloatArray) -> None:
    """Write the deformation gradient ``I + sum u_a ⊗ grad N_a`` at one point to F (3, 3).

    `gradient` (27, 3) are the referential shape gradients, 1/mm, and `u` (27, 3) the nodal displacements, mm.
    """
    for i in range(3):
        for j in range(3):
            F[i, j] = 1.0 if i == j else 0.0
    for a in range(NODES):
        for i in range(3):
            for j in range(3):
                F[i, j] += u[a, i] * gradient[a, j]


@kernel
def determinant(F: FloatArray) -> float:
    """Return the determinant of a matrix (3, 3)."""
    c00 = F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1]
    c01 = F[1, 2] * F[2, 0] - F[1, 0] * F[2, 2]
    c02 = F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0]
    return F[0, 0] * c00 + F[0, 1] * c01 + F[0, 2] * c02


@kernel
def spatial_gradients(gradient: FloatArray, F: FloatArray, g: FloatArray) -> float:
    """Write the spatial shape gradients ``F^-T grad N`` at one point to g (27, 3), 1/mm; return J.

    `gradient` (27, 3) are the referential ones, and F (3, 3) has a positive determinant.
    """
    c00 = F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1]
    c01 = F[1, 2] * F[2, 0] - F[1, 0] * F[2, 2]
    c02 = F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0]
    J = F[0, 0] * c00 + F[0, 1] * c01 + F[0, 2] * c02
    c10 = F[2, 1] * F[0, 2] - F[0, 1] * F[2, 2]
    c11 = F[0, 0] * F[2, 2] - F[0, 2] * F[2, 0]
    c12 = F[0, 1] * F[2, 0] - F[0, 0] * F[2, 1]
    c20 = F[0, 1] * F[1, 2] - F[0, 2] * F[1, 1]
    c21 = F[0, 2] * F[1, 0] - F[0, 0] * F[1, 2]
    c22 = F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]
    for a in range(NODES):
        x, y, z = gradient[a, 0], gradient[a, 1], gradient[a, 2]
        g[a, 0] = (c00 * x + c01 * y + c02 * z) / J
        g[a, 1] = (c10 * x + c11 * y + c12 * z) / J
        g[a, 2] = (c20 * x + c21 * y + c22 * z) / J
    return J


@kernel
def _add_geometric_stiffness(w: float, g: FloatArray, tau: FloatArray, S: FloatArray) -> None:
    """Add ``∫ g·tau·g`` to the upper triangle of S (27, 27)."""
    for a in range(NODES):
        x, y, z = g[a, 0], g[a, 1], g[a, 2]
        tx = w * (tau[0] * x + tau[3] * y + tau[5] * z)
        ty = w * (tau[3] * x + tau[1] * y + tau[4] * z)
        tz = w * (tau[5] * x + tau[4] * y + tau[2] * z)
        for b in range(a, NODES):
            S[a, b] += tx * g[b, 0] + ty * g[b, 1] + tz * g[b, 2]


@kernel
def _add_material_stiffness(w: float, g: FloatArray, c: FloatArray, DB: FloatArray, K: FloatArray) -> None:
    """Add ``∫ B^T c B`` to the upper triangle of K (81, 81), by rows so that the inner loop is contiguous."""
    for k in range(6):
        d0, d1, d2 = w * c[k, 0], w * c[k, 1], w * c[k, 2]
        d3, d4, d5 = w * c[k, 3], w * c[k, 4], w * c[k, 5]
        for b in range(NODES):
            x, y, z = g[b, 0], g[b, 1], g[b, 2]
            DB[k, 3 * b] = d0 * x + d3 * y + d5 * z
            DB[k, 3 * b + 1] = d1 * y + d3 * x + d4 * z
            DB[k, 3 * b + 2] = d2 * z + d4 * y + d5 * x
    for a in range(NODES):
        x, y, z = g[a, 0], g[a, 1], g[a, 2]
        for j in range(3 * a, DOFS):  # one row a loop: three at once are not vectorised
            K[3 * a, j] += x * DB[0, j] + y * DB[3, j] + z * DB[5, j]
        for j in range(3 * a, DOFS):
            K[3 * a + 1, j] += y * DB[1, j] + x * DB[3, j] + z * DB[4, j]
        for j in range(3 * a, DOFS):
            K[3 * a + 2, j] += z * DB[2, j] + y * DB[4, j] + x * DB[5, j]


@kernel
def add_volumetric(pressure_J: float, tau: FloatArray, c: FloatArray) -> None:
    """Add stress ``p J I`` and tangent ``p J (I ⊗ I - 2 II)`` of the pressure to tau (6,) and c (6, 6)."""
    for i in range(3):
        tau[i] += pressure_J
        for j in range(3):
            c[i, j] += pressure_J
        c[i, i] -= 2.0 * pressure_J
        c[i + 3, i + 3] -= pressure_J


@kernel
def deform_cells(cells: Cells, u: FloatArray, F: FloatArray) -> bool:
    """Write the deformation gradient (n_cells, n_points, 3, 3) at every Gauss point.

    Return whether no cell is inverted; after the first inverted cell, nothing more is written.
    """
    ue = np.empty((NODES, 3))
    for e in range(len(cells.nodes)):
        for a in range(NODES):
            for i in range(3):
                ue[a, i] = u[cells.nodes[e, a], i]
        for q in range(len(cells.basis)):
            deformation_gradient(cells.gradient[e, q], ue, F[e, q])
            if not determinant(F[e, q]) > 0.0:
                return False
    return True


@kernel
def add_residual(
    cells: Cells, response: Response, bulk: FloatArray, p: FloatArray, residual: FloatArray, condensed: Condensed
) -> float:
    """Add the condensed residual of all cells to (3 n,) N.

    Parameters
    ----------
    cells, response
        Tables, and response of the law at the Gauss points.
    bulk
        (n_cells,) bulk modulus, MPa.
    p
        (n_cells, 4) MPa pressure.
    residual
        Contributions are added to it.
    condensed
        Overwritten.

    Returns
    -------
    float
        Stored energy, mJ; infinite if the energy of the law is.
    """
    g, r, tau = np.empty((NODES, 3)), np.empty(DOFS), np.empty(6)
    energy = 0.0
    for e in range(len(cells.nodes)):
        own, C, rp = bulk[e], condensed.coupling[e], condensed.volume_residual[e]
        r[:] = 0.0
        C[:, :] = 0.0
        rp[:] = 0.0
        for q in range(len(cells.basis)):
            w = cells.weight[e, q]
            J = spatial_gradients(cells.gradient[e, q], response.F[e, q], g)
            pressure = 0.0
            for k in range(PRESSURES):
                pressure += cells.basis[q, k] * p[e, k]
            energy += w * (response.energy[e, q] + pressure * (J - 1.0) - pressure * pressure / (2.0 * own))
            for k in range(6):
                tau[k] = response.tau[e, q, k] + (pressure * J if k < 3 else 0.0)
            for a in range(NODES):
                x, y, z = g[a, 0], g[a, 1], g[a, 2]
                r[3 * a] += w * (tau[0] * x + tau[3] * y + tau[5] * z)
                r[3 * a + 1] += w * (tau[3] * x + tau[1] * y + tau[4] * z)
                r[3 * a + 2] += w * (tau[5] * x + tau[4] * y + tau[2] * z)
            for k in range(PRESSURES):
                wb = w * cells.basis[q, k]
                rp[k] += wb * (J - 1.0 - pressure / own)
                for a in range(NODES):
                    for i in range(3):
                        C[k, 3 * a + i] += wb * J * g[a, i]
        for k in range(PRESSURES):
            factor = 0.0
            for m in range(PRESSURES):
                factor += own * cells.inverse_mass[e, k, m] * rp[m]
            for j in range(DOFS):
                r[j] += factor * C[k, j]
        for j in range(DOFS):
            residual[3 * cells.nodes[e, j // 3] + j % 3] += r[j]
    return energy


@kernel
def add_tangent(
    cells: Cells, response: Response, bulk: FloatArray, p: FloatArray, coupling: FloatArray, data: FloatArray
) -> None:
    """Add the condensed tangent of all cells to the values (nnz,) of the sparse matrix.

    `coupling` (n_cells, 4, 81) mm² was written by `add_residual` at the same state; for the rest see there.
    """
    g, tau, c = np.empty((NODES, 3)), np.empty(6), np.empty((6, 6))
    DB, K, S = np.empty((6, DOFS)), np.empty((DOFS, DOFS)), np.empty((NODES, NODES))
    for e in range(len(cells.nodes)):
        K[:, :] = 0.0
        S[:, :] = 0.0
        for q in range(len(cells.basis)):
            w = cells.weight[e, q]
            J = spatial_gradients(cells.gradient[e, q], response.F[e, q], g)
            pressure = 0.0
            for k in range(PRESSURES):
                pressure += cells.basis[q, k] * p[e, k]
            tau[:] = response.tau[e, q]
            c[:, :] = response.c[e, q]
            add_volumetric(pressure * J, tau, c)
            _add_geometric_stiffness(w, g, tau, S)
            _add_material_stiffness(w, g, c, DB, K)
        _condense(bulk[e], cells.inverse_mass[e], coupling[e], S, K)
        at = 0
        for i in range(DOFS):
            for j in range(i, DOFS):
                target = cells.place[e, at]
                at += 1
                if target >= 0:
                    data[target] += K[i, j]


@kernel
def _condense(bulk: float, inverse_mass: FloatArray, C: FloatArray, S: FloatArray, K: FloatArray) -> None:
    """Add the geometric part S (27, 27) and the condensed pressures to the upper triangle of K (81, 81)."""
    for a in range(NODES):
        for b in range(a, NODES):
            for i in range(3):
                K[3 * a + i, 3 * b + i] += S[a, b]
    MC = np.zeros((PRESSURES, DOFS))
    for k in range(PRESSURES):
        for m in range(PRESSURES):
            factor = bulk * inverse_mass[k, m]
            for j in range(DOFS):
                MC[k, j] += factor * C[m, j]
    for i in range(DOFS):
        c0, c1, c2, c3 = C[0, i], C[1, i], C[2, i], C[3, i]
        for j in range(i, DOFS):
            K[i, j] += c0 * MC[0, j] + c1 * MC[1, j] + c2 * MC[2, j] + c3 * MC[3, j]


@kernel
def recover_pressure(cells: Cells, bulk: FloatArray, condensed: Condensed, du: FloatArray, dp: FloatArray) -> None:
    """Write the pressure increments ``dp = K M^-1 (C du + r_p)`` (n_cells, 4) MPa to `dp`.

    `du` (n, 3) mm is the increment of displacement; `condensed` was written by `add_residual`.
    """
    rhs = np.empty(PRESSURES)
    for e in range(len(cells.nodes)):
        for k in range(PRESSURES):
            rhs[k] = condensed.volume_residual[e, k]
            for a in range(NODES):
                for i in range(3):
                    rhs[k] += condensed.coupling[e, k, 3 * a + i] * du[cells.nodes[e, a], i]
        for k in range(PRESSURES):
            total = 0.0
            for m in range(PRESSURES):
                total += cells.inverse_mass[e, k, m] * rhs[m]
            dp[e, k] = bulk[e] * total
