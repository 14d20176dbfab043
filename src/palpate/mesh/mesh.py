"""The mesh of a dome: quadratic hexahedra, named sets, and the way from a surface point to its cell."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.core import FloatArray, IntArray
from palpate.design import Skin
from palpate.mesh.spec import MeshSpec


@dataclass(frozen=True)
class Mesh:
    """27-node hexahedra of half a dome (x >= 0) or a whole one.

    Attributes
    ----------
    skin, spec
        What was meshed, and how.
    nodes
        (n, 3) mm, dome's frame.
    cells
        (n_cells, 27) node numbers, lexicographic; the third local axis runs from inner to outer surface. Those that
        fill the skin are the first.
    inner_faces, outer_faces
        (n_faces, 9) node numbers of the 9-node faces of the two surfaces.
    inner_disc
        (n, 2) place of every node of the wall, which are the first, on the unit disc (polar angle over that of the
        rim, azimuth).
    base
        Nodes of the base annulus, of the far end's where a skin is open there, and of a filling bonded to its window:
        fixed in x, y and z.
    mirror
        Nodes of the mirror plane x = 0 (empty for a whole dome).
    pole
        (2,) place on that disc to which a press has moved the pole of the mesh: under the point of first touch; None
        where it is the apex as yet.
    pole_inner, pole_outer
        Node at the pole of each surface.
    filling
        How many of the cells fill the skin.
    """

    skin: Skin
    spec: MeshSpec
    nodes: FloatArray
    cells: IntArray
    inner_faces: IntArray
    outer_faces: IntArray
    inner_disc: FloatArray
    base: IntArray
    mirror: IntArray
    pole: FloatArray | None
    pole_inner: int
    pole_outer: int
    filling: int = 0
