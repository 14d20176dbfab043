"""Nodes, elements, sets and surfaces of a deck.

A 27-node hexahedron becomes a 20-node one without its face and centre nodes; numbers of nodes and cells are those of
the mesh plus one. A shell consists of the middle level of nodes, with each 9-node face divided into four. ::

       7--6--5        8--15--7           numbering of Abaqus and CalculiX: corners of the
      /|    /|      16    14 |           face zeta = -1 (inner, S1), of zeta = +1 (outer, S2),
     4--3--2 |      5--13--6 19          then the middles of their edges, then of the edges along zeta
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.fea.deck_spec import DeckElement, Dialect
from palpate.mechanics import BRICK
from palpate.mesh import Mesh

_QUARTERS = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
"""Corners of the four quadrilaterals of a 9-node face, counter-clockwise from outside."""

_PER_LINE = 16
"""Maximum number of entries in a line in either dialect."""


@dataclass(frozen=True)
class DeckMesh:
    """Mesh of a deck; nodes and elements are numbered from 0.

    Attributes
    ----------
    kind
        Element type, e.g. ``C3D20R``.
    points
        (n, 3) mm nodes of the palpate mesh; a deck lists those in `used`.
    used
        Nodes that belong to an element.
    elements
        (n_elements, 20 or 4) nodes.
    node_sets, element_sets
        Name → node or element numbers.
    surfaces
        Name → (element set, face label).
    """

    kind: str
    points: FloatArray
    used: IntArray
    elements: IntArray
    node_sets: dict[str, IntArray]
    element_sets: dict[str, IntArray]
    surfaces: dict[str, tuple[str, str]]


def deck_mesh(mesh: Mesh, dialect: Dialect, element: DeckElement) -> DeckMesh:
    """Return nodes, elements, sets and surfaces of a mesh in a dialect."""
    return _shell(mesh) if element is DeckElement.SHELL else _solid(mesh, dialect)


def _solid(mesh: Mesh, dialect: Dialect) -> DeckMesh:
    elements = mesh.cells[:, BRICK]
    used, fill = np.unique(elements), mesh.filling
    parts = {"GEL": np.arange(fill), "SKIN": np.arange(fill, len(elements))} if fill else {}
    first_outer = len(mesh.cells) - len(mesh.outer_faces)
    return DeckMesh(
        kind="C3D20R" if dialect is Dialect.CALCULIX else "C3D20RH",
        points=mesh.nodes,
        used=used,
        elements=elements,
        node_sets={
            "BASE": np.intersect1d(mesh.base, used),
            "INNER": np.intersect1d(mesh.inner_faces, used),
            "OUTER": np.intersect1d(mesh.outer_faces, used),
            "APEX": _apex(mesh, mesh.pole_inner, mesh.pole_outer),
            "MIRROR": np.intersect1d(mesh.mirror, used),
        },
        element_sets={
            "DOME": np.arange(len(elements)),
            **parts,
            "INNER_CELLS": np.arange(fill, fill + len(mesh.inner_faces)),
            "OUTER_CELLS": np.arange(first_outer, len(elements)),
        },
        surfaces={"INNER_FACE": ("INNER_CELLS", "S1"), "OUTER_FACE": ("OUTER_CELLS", "S2")},
    )


def _shell(mesh: Mesh) -> DeckMesh:
    if mesh.filling:
        raise PalpateError(
            "A filled skin cannot be meshed by shells.",
            "Write the deck with --element solid.",
            code="deck-filled-shell",
        )
    layers = mesh.spec.layers
    level = len(mesh.nodes) // (2 * layers + 1) * layers
    faces = mesh.inner_faces + level
    elements = faces[:, _QUARTERS].reshape(-1, 4)
    used = np.unique(elements)
    return DeckMesh(
        kind="S4R",
        points=mesh.nodes,
        used=used,
        elements=elements,
        node_sets={
            "BASE": np.intersect1d(mesh.base, used),
            "INNER": used,
            "OUTER": used,
            "APEX": _apex(mesh, mesh.pole_inner + level),
            "MIRROR": np.intersect1d(mesh.mirror, used),
        },
        element_sets={"DOME": np.arange(len(elements))},
        surfaces={"INNER_FACE": ("DOME", "SNEG"), "OUTER_FACE": ("DOME", "SPOS")},
    )


def _apex(mesh: Mesh, *numbers: int) -> IntArray:
    """Return these node numbers, or an empty array if the skin is open at the apex."""
    return np.array([] if mesh.skin.hole else numbers, int)


def mesh_lines(deck: DeckMesh) -> Iterator[str]:
    """Yield the lines of nodes, elements, sets and surfaces; empty sets are left out."""
    yield "** Nodes of the dome: number, x, y, z in mm"
    yield "*NODE, NSET=DOME_NODES"
    yield from node_lines(deck.used, deck.points[deck.used])
    yield "** Elements: number, nodes"
    yield f"*ELEMENT, TYPE={deck.kind}, ELSET=DOME"
    for number, nodes in enumerate(deck.elements):
        yield from _wrapped([number + 1, *(nodes + 1)])
    yield "** Node sets: BASE fixed annulus, INNER and OUTER surface, APEX inner and outer apex, MIRROR plane x = 0"
    for name, members in deck.node_sets.items():
        if len(members):
            yield f"*NSET, NSET={name}"
            yield from _rows(members + 1)
    for name, members in deck.element_sets.items():
        if name != "DOME":
            yield f"*ELSET, ELSET={name}"
            yield from _rows(members + 1)
    for name, (cells, face) in deck.surfaces.items():
        yield f"*SURFACE, NAME={name}, TYPE=ELEMENT"
        yield f"{cells}, {face}"


def node_lines(numbers: Iterable[int] | IntArray, points: FloatArray) -> Iterator[str]:
    """Yield lines ``number, x, y, z`` of nodes numbered from 0 in the mesh; a deck numbers from 1."""
    for number, (x, y, z) in zip(numbers, points, strict=True):
        yield f"{number + 1}, {x:.10g}, {y:.10g}, {z:.10g}"


def _wrapped(numbers: list[int]) -> Iterator[str]:
    """Yield one record over as many lines as needed; a continued line ends with a comma."""
    lines = [numbers[at : at + _PER_LINE] for at in range(0, len(numbers), _PER_LINE)]
    for k, line in enumerate(lines):
        yield ", ".join(map(str, line)) + ("," if k < len(lines) - 1 else "")


def _rows(numbers: IntArray) -> Iterator[str]:
    for at in range(0, len(numbers), _PER_LINE):
        yield ", ".join(map(str, numbers[at : at + _PER_LINE]))
