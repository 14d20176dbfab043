"""The mesh of a skin: quadratic hexahedra and named sets."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.core import FloatArray, IntArray
from palpate.design import Skin
from palpate.mesh.spec import MeshSpec


@dataclass(frozen=True)
class Mesh:
    """27-node hexahedra of half a skin (x >= 0) or a whole one.

    Attributes
    ----------
    skin, spec
        The skin, and the spec of the mesh.
    nodes
        (n, 3) mm, in the skin's frame.
    cells
        (n_cells, 27) node numbers, lexicographic; the third local axis runs from inner to outer surface. Cells of a
        filling are the first.
    inner_faces, outer_faces
        (n_faces, 9) node numbers of the 9-node faces of the two surfaces.
    inner_disc
        (n, 2) place of every node of the skin, which are the first, on the unit disc (polar angle over that of the
        rim, azimuth).
    base
        Fixed nodes: of the base annulus, of the far end of an open skin, and of a filling bonded to its window.
    mirror
        Nodes of the mirror plane x = 0 (empty for a whole skin).
    pole
        (2,) place on the disc to which a press has moved the pole of the mesh: the first-contact point; None for the
        apex.
    pole_inner, pole_outer
        Node at the pole of each surface.
    filling
        Number of cells of the filling.
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
