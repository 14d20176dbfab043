"""Wall and contact law of a deck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.fea.deck_mesh import node_lines
from palpate.fea.deck_spec import DeckElement, DeckSpec, Dialect
from palpate.fea.spec import ObstacleSpec, check_half_model
from palpate.fea.wall import WallSpec
from palpate.mesh import Mesh

ROUGH_FRICTION = 10.0
"""Coefficient of friction used for no slip in CalculiX, which has no rough friction. By hand."""


@dataclass(frozen=True)
class DeckWall:
    """Rigid facets of an obstacle that is tangent to the skin; numbers are from 0.

    Attributes
    ----------
    words
        Label of the obstacle.
    numbers, points
        (m,) node numbers and (m, 3) mm: the facets' corners, and for bricks the corners inside the obstacle too.
    facets, element
        (k, 4 or 8) rows of `numbers`, counter-clockwise seen from inside, then the inner ones; number of the first
        element.
    """

    words: str
    numbers: IntArray
    points: FloatArray
    facets: IntArray
    element: int


def ascii_label(wall: ObstacleSpec) -> str:
    """Return the obstacle's label in ASCII."""
    return wall.label.replace("°", " deg")


def deck_wall(mesh: Mesh, obstacle_spec: ObstacleSpec, elements: int, dialect: Dialect) -> DeckWall:
    """Return the obstacle over a mesh; `elements` are already numbered."""
    check_half_model(mesh, obstacle_spec)
    if obstacle_spec.moves_laterally:
        raise PalpateError(
            f"The obstacle of a deck moves along one line; this one also moves laterally: {obstacle_spec.label}.",
            "Leave out lateral motion and twist, or press with a wall instead of a route.",
            code="deck-wall-drifts",
        )
    if isinstance(obstacle_spec, WallSpec) and obstacle_spec.curvature:
        raise PalpateError(
            "A deck cannot contain a curved wall.",
            "Leave out the curvature, or press with a ball.",
            code="deck-wall-bent",
        )
    obstacle, touched = obstacle_spec.at_first_contact(mesh)
    half = max(
        2.0 * (mesh.skin.outer_widest[0] + mesh.skin.thickness),
        _farthest(mesh, touched, obstacle_spec.approach_axis(mesh)),
    )
    points, facets = obstacle.patch(touched, half)
    if dialect is Dialect.CALCULIX:
        gap, thick = obstacle.gap(points), 0.1 * min(half, np.ptp(points, axis=0).max())
        if gap.curvature is not None:  # the normals of a rounded body meet at its radius
            thick = min(thick, 0.5 / float(np.linalg.norm(gap.curvature, 2, axis=(1, 2)).max()))
        inner = points + thick * gap.normal
        points, facets = np.concatenate([points, inner]), np.concatenate([facets, facets + len(points)], axis=1)
    return DeckWall(ascii_label(obstacle_spec), len(mesh.nodes) + np.arange(len(points)), points, facets, elements)


def _farthest(mesh: Mesh, touched: FloatArray, way: FloatArray) -> float:
    """Return the maximum distance in mm of the skin from the path of a point (3,) of the obstacle."""
    arm = mesh.nodes - touched
    return float(np.linalg.norm(arm - np.outer(arm @ way, way), axis=1).max())


def wall_lines(wall: DeckWall, dialect: Dialect) -> Iterator[str]:
    """Yield the lines of the rigid obstacle: its nodes, elements, set and surface WALL_FACE."""
    numbers = wall.numbers
    yield f"** Rigid obstacle, tangent to the outer surface at depth 0: {wall.words}"
    yield "*NODE, NSET=WALL_NODES"
    yield from node_lines(numbers, wall.points)
    if dialect is Dialect.CALCULIX:
        yield "** bricks, all nodes of which are prescribed: rigid, whatever their stiffness"
        yield "*ELEMENT, TYPE=C3D8, ELSET=WALL"
        yield from _facet_lines(wall, wall.facets)
        yield "*SURFACE, NAME=WALL_FACE, TYPE=ELEMENT"
        yield "WALL, S1"
        return
    yield "*NODE, NSET=WALL_REF"
    yield from node_lines([numbers[-1] + 1], wall.points.mean(axis=0, keepdims=True))
    yield "** listed clockwise from inside the obstacle: the positive side faces the skin"
    yield "*ELEMENT, TYPE=R3D4, ELSET=WALL"
    yield from _facet_lines(wall, wall.facets[:, ::-1])
    yield "*RIGID BODY, ELSET=WALL, REF NODE=WALL_REF"
    yield "*SURFACE, NAME=WALL_FACE, TYPE=ELEMENT"
    yield "WALL, SPOS"


def _facet_lines(wall: DeckWall, facets: IntArray) -> Iterator[str]:
    for number, facet in enumerate(facets, start=wall.element + 1):
        yield ", ".join(map(str, [number, *(wall.numbers[facet] + 1)]))


def contact_lines(wall: ObstacleSpec, spec: DeckSpec) -> Iterator[str]:
    """Yield the lines of the contact law and the pair OUTER_FACE, WALL_FACE."""
    calculix = spec.dialect is Dialect.CALCULIX
    yield f"** Contact: linear penalty of {spec.penalty:g} MPa/mm"
    if spec.element is DeckElement.SHELL:
        yield "** contact includes the shell's thickness, so first contact is that of the outer surface"
    yield "*SURFACE INTERACTION, NAME=TOUCH"
    yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
    yield f"{spec.penalty:.8g}, 1e-06, 0.001" if calculix else f"{spec.penalty:.8g}"
    yield from _friction_lines(wall, spec)
    kind = "NODE TO SURFACE" if calculix else "SURFACE TO SURFACE"
    yield f"*CONTACT PAIR, INTERACTION=TOUCH, TYPE={kind}"
    yield "OUTER_FACE, WALL_FACE"


def _friction_lines(wall: ObstacleSpec, spec: DeckSpec) -> Iterator[str]:
    slope = spec.tangential_ratio * spec.penalty
    if wall.friction == 0:
        yield "** frictionless: no *FRICTION"
    elif np.isfinite(wall.friction):
        yield f"** Coulomb friction, coefficient {wall.friction:g}"
        yield "*FRICTION"
        yield f"{wall.friction:g}, {slope:.8g}" if spec.dialect is Dialect.CALCULIX else f"{wall.friction:g}"
    elif spec.dialect is Dialect.CALCULIX:
        yield f"** no slip: CalculiX has no rough friction; coefficient {ROUGH_FRICTION:g} with a stick slope"
        yield "*FRICTION"
        yield f"{ROUGH_FRICTION:g}, {slope:.8g}"
    else:
        yield "** no slip: rough friction, separation allowed"
        yield "*FRICTION, ROUGH"
