"""The 20-node brick inside a 27-node cell: its shape functions, and the nodes that it lacks.

Corner nodes at ``p``: ``(1 + xi p1)(1 + eta p2)(1 + zeta p3)(xi p1 + eta p2 + zeta p3 - 2) / 8``; a node in the
middle of an edge along xi: ``(1 - xi²)(1 + eta p2)(1 + zeta p3) / 4`` (Zienkiewicz & Taylor, volume 1, 8.11).
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, IntArray

BRICK = np.array([0, 2, 8, 6, 18, 20, 26, 24, 1, 5, 7, 3, 19, 23, 25, 21, 9, 11, 17, 15])
"""Nodes of a 27-node cell in the order of a 20-node brick (Abaqus, CalculiX and VTK agree)."""

_PLACES = np.array([[i - 1.0, j - 1.0, k - 1.0] for k in range(3) for j in range(3) for i in range(3)])
"""(27, 3) local coordinates of the nodes of a cell."""


def shape_brick(local: FloatArray) -> FloatArray:
    """Return the shape functions (n, 20) of the 20-node brick at local coordinates (n, 3)."""
    shape = np.empty((len(local), len(BRICK)))
    for a, place in enumerate(_PLACES[BRICK]):
        along = place == 0.0
        across = np.prod(1 + local[:, ~along] * place[~along], axis=1)
        if along.any():
            shape[:, a] = across * (1 - local[:, along][:, 0] ** 2) / 4
        else:
            shape[:, a] = across * (local @ place - 2) / 8
    return shape


def fill_nodes(cells: IntArray, field: FloatArray) -> FloatArray:
    """Fill the face and centre nodes of 27-node cells in a nodal field (..., n, k) from the brick's nodes.

    `cells` (n_cells, 27) are node numbers; values of `field` at face and centre nodes are ignored.
    """
    left_out = np.setdiff1d(np.arange(27), BRICK)
    shape = shape_brick(_PLACES[left_out])
    filled = np.array(field, float)
    filled[..., cells[:, left_out], :] = np.einsum("ba,...eak->...ebk", shape, filled[..., cells[:, BRICK], :])
    return filled
