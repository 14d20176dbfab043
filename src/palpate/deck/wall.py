"""Wall and contact law of a deck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, IntArray
from palpate.deck.mesh import node_lines
from palpate.deck.spec import DeckElement, DeckSpec, Dialect
from palpate.fea import FRICTIONLESS, NO_SLIP, WallSpec, touch_point
from palpate.mesh import Mesh

ROUGH_FRICTION = 10.0
"""Coefficient of friction that stands for no slip in CalculiX, which has no rough friction."""


@dataclass(frozen=True)
class DeckWall:
    """A square rigid plate whose lower face is tangent to the dome.

    Attributes
    ----------
    normal
        (3,) unit normal, away from the dome.
    numbers
        (4 or 8,) node numbers (from 0): lower face counter-clockwise from above, then the upper face.
    points
        (4 or 8, 3) mm.
    element
        Element number (from 0).
    """

    normal: FloatArray
    numbers: IntArray
    points: FloatArray
    element: int


def deck_wall(mesh: Mesh, normal: FloatArray, elements: int, dialect: Dialect) -> DeckWall:
    """The plate over a mesh; `elements` are already numbered."""
    half = 2.0 * (mesh.dome.outer_radius + mesh.dome.thickness)
    along = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    along /= np.linalg.norm(along)
    across = np.cross(normal, along)
    middle = touch_point(mesh.dome, normal)
    sides = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    lower = np.array([middle + half * (a * along + b * across) for a, b in sides])
    upper = lower + 0.1 * half * normal
    points = np.concatenate([lower, upper]) if dialect is Dialect.CALCULIX else lower
    return DeckWall(normal, len(mesh.nodes) + np.arange(len(points)), points, elements)


def wall_lines(wall: DeckWall, dialect: Dialect) -> Iterator[str]:
    """Lines of the rigid plate: its nodes, element, set and surface WALL_FACE."""
    numbers = wall.numbers
    yield "** Rigid wall: a flat plate, tangent to the outer surface at depth 0"
    yield f"** outward normal {', '.join(f'{value:.8f}' for value in wall.normal)}"
    yield "*NODE, NSET=WALL_NODES"
    yield from node_lines(numbers, wall.points)
    if dialect is Dialect.CALCULIX:
        yield "** one brick, all nodes of which are prescribed: rigid, whatever its stiffness"
        yield "*ELEMENT, TYPE=C3D8, ELSET=WALL"
        yield ", ".join(map(str, [wall.element + 1, *(numbers + 1)]))
        yield "*SURFACE, NAME=WALL_FACE, TYPE=ELEMENT"
        yield "WALL, S1"
        return
    yield "*NODE, NSET=WALL_REF"
    yield from node_lines([numbers[-1] + 1], wall.points.mean(axis=0, keepdims=True))
    yield "** listed clockwise from above: the positive side faces the dome"
    yield "*ELEMENT, TYPE=R3D4, ELSET=WALL"
    yield ", ".join(map(str, [wall.element + 1, *(numbers[::-1] + 1)]))
    yield "*RIGID BODY, ELSET=WALL, REF NODE=WALL_REF"
    yield "*SURFACE, NAME=WALL_FACE, TYPE=ELEMENT"
    yield "WALL, SPOS"


def contact_lines(wall: WallSpec, spec: DeckSpec) -> Iterator[str]:
    """Lines of the contact law and the pair OUTER_FACE, WALL_FACE."""
    calculix = spec.dialect is Dialect.CALCULIX
    yield f"** Contact: linear penalty of {spec.penalty:g} MPa/mm"
    if spec.element is DeckElement.SHELL:
        yield "** the shell's thickness counts in contact, so first touch is that of the outer surface"
    yield "*SURFACE INTERACTION, NAME=TOUCH"
    yield "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
    yield f"{spec.penalty:.8g}, 1e-06, 0.001" if calculix else f"{spec.penalty:.8g}"
    yield from _friction_lines(wall, spec)
    kind = "NODE TO SURFACE" if calculix else "SURFACE TO SURFACE"
    yield f"*CONTACT PAIR, INTERACTION=TOUCH, TYPE={kind}"
    yield "OUTER_FACE, WALL_FACE"


def _friction_lines(wall: WallSpec, spec: DeckSpec) -> Iterator[str]:
    slope = spec.tangential_ratio * spec.penalty
    if wall.contact == FRICTIONLESS or wall.friction == 0:
        yield "** frictionless: no *FRICTION"
    elif wall.contact != NO_SLIP:
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
