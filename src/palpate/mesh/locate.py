"""Location of points of the inner surface in the mesh, so that markers need not be nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError
from palpate.mesh.hexahedron import shape_quadrilateral
from palpate.mesh.mesh import Mesh

_SURFACE_DISTANCE_MM = 0.05
"""Maximum distance of a point from the surface of the mesh. By hand."""
_CANDIDATES = 24
"""Number of candidate faces by distance of their centres; faces may be ten times as long as wide.
By hand."""
_INSIDE = 1.0 + 1e-9
"""Maximum of local coordinate plus residual of a point inside a face."""
_MARGIN = 0.3
"""Distance from the box of a face's nodes, over its longer side, beyond which nothing is inside.

A biquadratic map leaves the box of its nodes by at most 9/32 of its side: its Lebesgue constant is 25/16.
"""


@dataclass(frozen=True)
class SurfacePoints:
    """Points of the inner surface as weights on nodes.

    Attributes
    ----------
    nodes
        (m, 9) node numbers of the face that contains each point.
    weights
        (m, 9) shape functions there; they sum to one.
    """

    nodes: IntArray
    weights: FloatArray

    def interpolate(self, field: FloatArray) -> FloatArray:
        """Interpolate a nodal field (..., n, k) to the points: (..., m, k)."""
        result: FloatArray = np.einsum("ma,...mak->...mk", self.weights, field[..., self.nodes, :])
        return result


def locate_inner(mesh: Mesh, points: FloatArray) -> SurfacePoints:
    """Locate points of the undeformed inner surface, or the roots of pins by their tips.

    Parameters
    ----------
    mesh
        Mesh of a skin; for a half one the points must have x >= 0.
    points
        (m, 3) mm, within 0.05 mm of the marked surface.

    Raises
    ------
    PalpateError
        If a point is not on the marked surface or is beyond its rim.
    """
    return _locate(mesh, _on_disc(mesh, np.asarray(points, float)))


def locate_nodes(mesh: Mesh, other: Mesh) -> SurfacePoints:
    """Locate the nodes of another mesh of the same skin, with equal layers and both half or whole."""
    layers = 2 * mesh.spec.layers + 1
    first = _locate(mesh, other.inner_disc[: len(other.inner_disc) // layers])
    above = np.repeat(np.arange(layers) * (len(mesh.inner_disc) // layers), len(first.nodes))[:, None]
    return SurfacePoints(np.tile(first.nodes, (layers, 1)) + above, np.tile(first.weights, (layers, 1)))


def _locate(mesh: Mesh, place: FloatArray) -> SurfacePoints:
    """Return places (m, 2) of the unit disc as weights on the nodes of the inner surface."""
    faces = mesh.inner_faces
    corners = mesh.inner_disc[faces]
    middles, sought = corners[:, 4], place
    if mesh.skin.hole:  # faces of a tube are long in azimuth on the disc, but not on the skin
        middles, sought = mesh.nodes[faces[:, 4]], mesh.skin.point(place, 0.0)
    _, near = cKDTree(middles).query(sought, k=min(_CANDIDATES, len(faces)))
    near = near.reshape(len(place), -1)
    cells = corners[near]
    if mesh.skin.hole:
        cells, place = _unroll(cells, place)
    best, local = np.zeros(len(place), int), np.zeros((len(place), 2))
    left = np.arange(len(place))
    for choose in (_first, _near_boxes, _all):  # most points lie in the face with the closest centre
        tried = choose(cells[left], place[left])
        found = np.zeros((*tried.shape, 2))
        outside = np.full(tried.shape, np.inf)
        found[tried], miss = _invert(cells[left][tried], np.repeat(place[left], tried.sum(axis=1), axis=0))
        outside[tried] = np.abs(found[tried]).max(axis=-1) + miss
        best[left] = np.argmin(outside, axis=1)
        local[left] = found[np.arange(len(left)), best[left]]
        left = left[outside.min(axis=1) > _INSIDE]
        if not len(left):
            break
    weights, _ = shape_quadrilateral(np.clip(local, -1, 1))
    return SurfacePoints(nodes=faces[near[np.arange(len(place)), best]], weights=weights)


def _first(cells: FloatArray, place: FloatArray) -> BoolArray:
    return np.arange(cells.shape[1]) == np.zeros((len(place), 1))


def _near_boxes(cells: FloatArray, place: FloatArray) -> BoolArray:
    """Whether places (m, 2) are near the boxes of the nodes of faces (m, k, 9, 2)."""
    low, high = cells.min(axis=2), cells.max(axis=2)
    margin = _MARGIN * (high - low).max(axis=-1, keepdims=True)
    return np.asarray(((low - margin < place[:, None]) & (place[:, None] < high + margin)).all(axis=-1))


def _all(cells: FloatArray, place: FloatArray) -> BoolArray:
    return np.ones(cells.shape[:2], bool)


def _unroll(corners: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Convert faces (m, k, 9, 2) and places (m, 2) of the disc to radius and angle from the place.

    Faces of a tube become rectangles.
    """
    radius, angle = np.hypot(*place.T), np.arctan2(place[:, 1], place[:, 0])
    turn = np.arctan2(corners[..., 1], corners[..., 0]) - angle[:, None, None]
    turn = (turn + np.pi) % (2 * np.pi) - np.pi
    away = np.hypot(corners[..., 0], corners[..., 1])
    return np.stack([away, turn], axis=-1), np.column_stack([radius, np.zeros_like(radius)])


def _on_disc(mesh: Mesh, points: FloatArray) -> FloatArray:
    off = np.abs(mesh.skin.distance(points))
    if off.max(initial=0.0) > _SURFACE_DISTANCE_MM:
        worst = int(np.argmax(off))
        raise PalpateError(
            f"Point {worst + 1} at {np.round(points[worst], 3).tolist()} mm is {off[worst]:.3g} mm away from the "
            f"{'tips of the pins' if mesh.skin.pin else 'inner surface'} of {mesh.skin.name}.",
            f"Give points within {_SURFACE_DISTANCE_MM} mm of it.",
            code="point-off-surface",
        )
    place = mesh.skin.disc(points)
    beyond = np.maximum(np.hypot(place[:, 0], place[:, 1]), 1.0)
    if beyond.max(initial=0.0) > 1 + 1e-6:
        worst = int(np.argmax(beyond))
        raise PalpateError(
            f"Point {worst + 1} at {np.round(points[worst], 3).tolist()} mm lies below the base plane z = 0.",
            "Give points of the skin above the base plane.",
            code="point-below-base",
        )
    return np.asarray(place / beyond[:, None])


def _invert(flat: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return local coordinates (n, 2) of places (n, 2) in faces (n, 9, 2), by Newton's method.

    Return also the residual distance over the size of the face (n,).
    """
    local = np.zeros((len(flat), 2))
    for _ in range(12):
        value, gradient = shape_quadrilateral(local)
        gap = target - np.einsum("na,nai->ni", value, flat)
        jacobian = np.einsum("nai,naj->nij", flat, gradient)
        determinant = np.linalg.det(jacobian)
        safe = np.abs(determinant) > 1e-14
        step = np.zeros_like(local)
        step[safe] = np.linalg.solve(jacobian[safe], gap[safe][..., None])[..., 0]
        local = np.clip(local + step, -3, 3)
    value, _ = shape_quadrilateral(local)
    miss = np.linalg.norm(target - np.einsum("na,nai->ni", value, flat), axis=1)
    size = np.linalg.norm(np.ptp(flat, axis=1), axis=1)
    return local, miss / size
