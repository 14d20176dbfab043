"""Quality measures of a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.mesh.hexahedron import gauss_points, shape_hexahedron
from palpate.mesh.mesh import Mesh


@dataclass(frozen=True)
class MeshQuality:
    """Quality of a mesh.

    Attributes
    ----------
    volume
        Volume of the mesh, mm³ (of half a skin for a half mesh).
    least_scaled_jacobian
        Minimum over the cells of smallest over largest Jacobian determinant at the Gauss points: 1 for a
        parallelepiped, 0 for a degenerate cell.
    volume_ratio
        Volume of the largest cell over that of the smallest.
    """

    volume: float
    least_scaled_jacobian: float
    volume_ratio: float


def measure_quality(mesh: Mesh) -> MeshQuality:
    """Measure the quality of a mesh at its 3 × 3 × 3 Gauss points."""
    points, weights = gauss_points((3, 3, 3))
    _, gradient = shape_hexahedron(points)
    determinant = np.linalg.det(np.einsum("eai,gaj->egij", mesh.nodes[mesh.cells], gradient))
    volume = determinant @ weights
    return MeshQuality(
        volume=float(volume.sum()),
        least_scaled_jacobian=float((determinant.min(axis=1) / determinant.max(axis=1)).min()),
        volume_ratio=float(volume.max() / volume.min()),
    )
