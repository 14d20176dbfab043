"""Drawn surface of a mesh as triangles (outer and inner side, clamped base), and cells for a cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, IntArray
from palpate.mesh import Mesh

PARTS = ("outer", "inner", "base")
"""Parts of a shell, in the order of its triangles."""

_QUADS = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
"""The four quadrilaterals of a face with nine nodes, lexicographic."""
_TRIANGLES = np.concatenate([_QUADS[:, [0, 1, 2]], _QUADS[:, [0, 2, 3]]])


@dataclass(frozen=True, eq=False)
class Shell:
    """Triangles and cells of a skin; a half skin is completed by the mirror image x → −x.

    Attributes
    ----------
    nodes
        (v,) number of the node at each vertex; a node on an edge between two parts has a vertex in each. Nodes inside
        the skin are the last.
    triangles
        (k, 3) numbers of vertices.
    parts
        First triangle and number of triangles, for each of `PARTS`.
    seam
        (v,) whether a vertex lies in the mirror plane.
    cells
        (c, 27) numbers of vertices of each cell, in the order of `palpate.mesh.Mesh.cells`.
    """

    nodes: IntArray
    triangles: IntArray
    parts: dict[str, tuple[int, int]]
    seam: BoolArray
    cells: IntArray


def build_shell(mesh: Mesh) -> Shell:
    """Triangulate the visible surface of a mesh; every node of the skin becomes a vertex."""
    faces = _cell_faces(mesh)
    pieces = (
        mesh.outer_faces,
        mesh.inner_faces,
        faces[np.isin(faces, mesh.base).all(axis=1)],
    )
    nodes: list[IntArray] = []
    triangles: list[IntArray] = []
    parts, first = {}, 0
    for name, piece in zip(PARTS, pieces, strict=True):
        own, numbers = np.unique(piece, return_inverse=True)
        corners = _turn_outward(mesh, own, numbers.reshape(-1, 9)[:, _TRIANGLES].reshape(-1, 3), name)
        parts[name] = (first, len(corners))
        first += len(corners)
        triangles.append(corners + sum(len(earlier) for earlier in nodes))
        nodes.append(own)
    cells = mesh.cells[mesh.filling :]
    every = np.concatenate([*nodes, np.setdiff1d(cells, np.concatenate(nodes))])
    vertices = np.zeros(len(mesh.nodes), int)
    vertices[every] = np.arange(len(every))
    return Shell(every, np.concatenate(triangles), parts, np.isin(every, mesh.mirror), vertices[cells])


def _turn_outward(mesh: Mesh, nodes: IntArray, triangles: IntArray, part: str) -> IntArray:
    """Return triangles (k, 3), numbers of `nodes`, counter-clockwise seen from outside the solid."""
    a, b, c = mesh.nodes[nodes][triangles].transpose(1, 0, 2)
    arm = mesh.skin.normal((a + b + c) / 3.0)
    below = a[:, 2:] < mesh.skin.height / 2  # where a skin is open at its far end, that is clamped as well
    ends = np.where(below, -1.0, 1.0) * [0.0, 0.0, 1.0]
    away = {"outer": arm, "inner": -arm, "base": ends}[part]
    wrong = (np.cross(b - a, c - a) * away).sum(axis=1) < 0
    turned: IntArray = np.where(wrong[:, None], triangles[:, ::-1], triangles)
    return turned


def _cell_faces(mesh: Mesh) -> IntArray:
    """(6 c, 9) faces of the skin's cells, each with its nodes in lexicographic order."""
    number = np.arange(27).reshape(3, 3, 3)
    sides = [number[0], number[2], number[:, 0], number[:, 2], number[:, :, 0], number[:, :, 2]]
    return np.concatenate([mesh.cells[mesh.filling :, side.reshape(-1)] for side in sides])
