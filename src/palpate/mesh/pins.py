"""Tips of pins on the inner surface: they follow its displacement and the rotation of its normal.

A tip at the distance p inside the root x along the outward normal n moves by ``u(x) - p (n' - n)``, with n' the
normal of the deformed surface. At every node n' is the mean over the adjacent faces, each ``∝ a × b`` with the
derivatives a, b of the deformed position by the face's local coordinates; between nodes it is interpolated. So
it is continuous. Like that of the normal of one face, its error decreases with the square of the cell size; it is
about a fifth smaller.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.mesh.hexahedron import shape_quadrilateral
from palpate.mesh.locate import SurfacePoints
from palpate.mesh.mesh import Mesh

_AT_NODES = shape_quadrilateral(np.array([[i, j] for j in (-1.0, 0.0, 1.0) for i in (-1.0, 0.0, 1.0)]))[1]
"""(9, 9, 2) derivatives of the shape functions at the nodes of a face."""


def marker_displacement(mesh: Mesh, places: SurfacePoints, displacement: FloatArray) -> FloatArray:
    """Return the displacement (n, m, 3) mm of markers for a displacement (n, n_nodes, 3) mm of the nodes.

    Markers of a skin with pins are their tips, and `places` their roots.
    """
    moved = places.interpolate(displacement)
    if not mesh.skin.pin:
        return moved
    still = np.zeros_like(mesh.nodes)[None]
    bent, rest = (_normals(mesh, mesh.nodes + each, still)[0] for each in (displacement, still))
    tips: FloatArray = moved - mesh.skin.pin * (_unit(places.interpolate(bent)) - _unit(places.interpolate(rest)))
    return tips


def marker_displacement_derivative(
    mesh: Mesh, places: SurfacePoints, displacement: FloatArray, rate: FloatArray, *, across: bool = False
) -> FloatArray:
    """Return the derivative (n, m, 3) of `marker_displacement`.

    `rate` (n, n_nodes, 3) is the derivative of the nodes' displacement. With `across`, it is antisymmetric about the
    mirror plane of a half model.
    """
    moved = places.interpolate(rate)
    if not mesh.skin.pin:
        return moved
    normals, changes = _normals(mesh, mesh.nodes + displacement, rate, across=across)
    tips: FloatArray = moved - mesh.skin.pin * _unit_rate(places.interpolate(normals), places.interpolate(changes))
    return tips


def _normals(
    mesh: Mesh, nodes: FloatArray, rate: FloatArray, *, across: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Return outward unit normals (n, n_nodes, 3) of the inner surface, and their derivative."""
    faces = mesh.inner_faces
    a, b = _tangents(nodes[:, faces])
    da, db = _tangents(rate[:, faces])
    crossed, change = np.cross(a, b), np.cross(da, b) + np.cross(a, db)
    total, turned = np.zeros_like(nodes), np.zeros(np.broadcast_shapes(nodes.shape, rate.shape))
    for at_nodes, at_faces in ((total, _unit(crossed)), (turned, _unit_rate(crossed, change))):
        np.add.at(at_nodes.swapaxes(0, 1), faces, np.moveaxis(at_faces, 0, 2))
    total[:, mesh.mirror, 0] = 0.0
    turned[:, mesh.mirror, slice(1, 3) if across else 0] = 0.0
    kept = np.unique(faces)
    normals, changes = np.zeros_like(total), np.zeros_like(turned)
    normals[:, kept] = _unit(total[:, kept])
    changes[:, kept] = _unit_rate(total[:, kept], turned[:, kept])
    return normals, changes


def _tangents(nodes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return derivatives (n, f, 9, 3) by the local coordinates at the nodes (n, f, 9, 3) of faces."""
    first, second = (np.einsum("qa,nfak->nfqk", _AT_NODES[..., k], nodes) for k in (0, 1))
    return first, second


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _unit_rate(vectors: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the derivative of the unit vectors along vectors (…, 3) that change at these rates."""
    unit, length = _unit(vectors), np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray((rates - (rates * unit).sum(axis=-1, keepdims=True) * unit) / length)
