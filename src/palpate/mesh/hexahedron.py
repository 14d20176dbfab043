"""The 27-node hexahedron: Lagrange shape functions, Gauss points and the numbering of nodes and faces.

Nodes are numbered lexicographically: node ``i + 3 j + 9 k`` is at ``(xi, eta, zeta) = (i - 1, j - 1, k - 1)``. In a
skin ``zeta`` runs through the thickness, from the inner (-1) to the outer (+1) surface, so the face ``zeta = -1`` is
nodes 0…8 and the face ``zeta = +1`` nodes 18…26, both numbered as 9-node quadrilaterals.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.core import FloatArray

INNER_FACE = np.arange(9)
OUTER_FACE = np.arange(18, 27)
CORNERS = np.array([0, 2, 8, 6, 18, 20, 26, 24])


def lagrange(xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return values and slopes (n, 3) at xi (n,) of the Lagrange polynomials of the nodes -1, 0, 1."""
    value = np.stack([xi * (xi - 1) / 2, 1 - xi * xi, xi * (xi + 1) / 2], axis=-1)
    slope = np.stack([xi - 0.5, -2 * xi, xi + 0.5], axis=-1)
    return value, slope


def shape_quadrilateral(xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shape functions (n, 9) of the 9-node quadrilateral, and their gradients (n, 9, 2).

    `xi` (n, 2) are local coordinates, by which the gradients are taken.
    """
    (a, da), (b, db) = lagrange(xi[:, 0]), lagrange(xi[:, 1])
    n = len(xi)
    value = np.einsum("nj,ni->nji", b, a).reshape(n, 9)
    gradient = np.stack(
        [np.einsum("nj,ni->nji", b, da).reshape(n, 9), np.einsum("nj,ni->nji", db, a).reshape(n, 9)], axis=-1
    )
    return value, gradient


def shape_hexahedron(xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shape functions (n, 27) of the 27-node hexahedron, and their gradients (n, 27, 3).

    `xi` (n, 3) are local coordinates, by which the gradients are taken.
    """
    (a, da), (b, db), (c, dc) = (lagrange(xi[:, axis]) for axis in range(3))
    n = len(xi)

    def product(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
        result: FloatArray = np.einsum("nk,nj,ni->nkji", z, y, x).reshape(n, 27)
        return result

    gradient = np.stack([product(da, b, c), product(a, db, c), product(a, b, dc)], axis=-1)
    return product(a, b, c), gradient


@cache
def gauss_points(counts: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return Gauss–Legendre points (n, len(counts)) of a line, square or cube, and their weights (n,).

    `counts` are the numbers of points along each local axis.
    """
    lines = [np.polynomial.legendre.leggauss(count) for count in counts]
    grids = np.meshgrid(*[line[0] for line in lines], indexing="ij")
    weights = np.ones(())
    for _, weight in lines:
        weights = np.multiply.outer(weights, weight)
    return np.stack([grid.ravel() for grid in grids], axis=-1), weights.ravel()
