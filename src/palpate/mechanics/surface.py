"""The surface of a solid that may touch an obstacle: quadrature points on its outer faces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, kernel
from palpate.mesh import gauss_points, shape_quadrilateral


class ContactFaces(NamedTuple):
    """Tables of the outer faces in the kernels.

    Attributes
    ----------
    nodes
        (n_faces, 9) node numbers.
    cell
        (n_faces,) cell of which each one is the face zeta = +1.
    shape
        (n_q, 9) shape functions at the quadrature points.
    weight
        (n_faces, n_q) mm² undeformed area of each point.
    """

    nodes: IntArray
    cell: IntArray
    shape: FloatArray
    weight: FloatArray


class OuterSurface:
    """Quadrature points of the outer faces of a solid.

    Parameters
    ----------
    nodes
        (n, 3) mm.
    faces, cell_of_face
        (n_faces, 9) node numbers of the outer faces, and (n_faces,) the cell of which each one is the face zeta = +1.
    points_per_side
        Gauss points along each side of a face.
    """

    def __init__(self, nodes: FloatArray, faces: IntArray, cell_of_face: IntArray, points_per_side: int = 4) -> None:
        points, self._quadrature = gauss_points((points_per_side, points_per_side))
        shape, self._slope = shape_quadrilateral(points)
        faces = np.ascontiguousarray(faces, dtype=np.int64)
        self.faces = ContactFaces(faces, cell_of_face, shape, self._areas(nodes[faces]))
        self.points = self.interpolate(nodes)

    def _areas(self, corners: FloatArray) -> FloatArray:
        tangents = np.einsum("fai,qaj->fqji", corners, self._slope)
        area: FloatArray = np.linalg.norm(np.cross(tangents[..., 0, :], tangents[..., 1, :]), axis=-1)
        return np.ascontiguousarray(area * self._quadrature)

    @property
    def area(self) -> float:
        """Undeformed area, mm²."""
        return float(self.faces.weight.sum())

    def interpolate(self, field: FloatArray) -> FloatArray:
        """Interpolate a nodal field (n, 3) to the quadrature points: (n_points, 3)."""
        values = np.zeros((len(self.faces.nodes), len(self.faces.shape), 3))
        for corner, share in zip(self.faces.nodes.T, self.faces.shape.T, strict=True):
            values += share[:, None] * field[corner][:, None]
        return values.reshape(-1, 3)

    def place(self, position: FloatArray) -> FloatArray:
        """Return the quadrature points (n_points, 3) mm of deformed nodes (n, 3) mm, by a compiled kernel."""
        return _place(self.faces, position)

    def node_areas(self, nodes: FloatArray) -> FloatArray:
        """Return the integral (n,) mm² of the shape function of each node of a body over its deformed surface."""
        area = np.zeros(len(nodes))
        np.add.at(area, self.faces.nodes, self._areas(nodes[self.faces.nodes]) @ self.faces.shape)
        return area

    def current_area(self, nodes: FloatArray, touching: BoolArray) -> float:
        """Return the deformed area in mm² of the points `touching` (n_points,), with deformed nodes (n, 3)."""
        return float(self._areas(nodes[self.faces.nodes]).ravel()[touching].sum())


@kernel
def _place(faces: ContactFaces, position: FloatArray) -> FloatArray:
    points = np.empty((len(faces.nodes) * len(faces.shape), 3))
    x = np.empty(3)
    for f in range(len(faces.nodes)):
        nodes = faces.nodes[f]
        for q in range(len(faces.shape)):
            x[:] = 0.0
            for a in range(9):
                for i in range(3):
                    x[i] += faces.shape[q, a] * position[nodes[a], i]
            for i in range(3):
                points[f * len(faces.shape) + q, i] = x[i]
    return points
