"""A deck: the complete input file of a press for Abaqus or CalculiX, in mm, N and MPa."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from palpate.core import PalpateError, atomic_write, provenance
from palpate.fea.deck_material import material_lines
from palpate.fea.deck_mesh import deck_mesh, mesh_lines
from palpate.fea.deck_spec import DeckElement, DeckSpec, Dialect
from palpate.fea.deck_step import boundary_lines, step_lines, time_point_lines
from palpate.fea.deck_wall import ascii_label, contact_lines, deck_wall, wall_lines
from palpate.fea.solve_press import increment_depths
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mesh import Mesh


def write_deck(
    path: Path, mesh: Mesh, material: Material, obstacle: ObstacleSpec, spec: DeckSpec | None = None
) -> None:
    """Write the deck of a press (see `deck_text`) to a file, completely or not at all.

    Raises
    ------
    PalpateError
        If the deck cannot be made, or the file cannot be written.
    """
    text = deck_text(mesh, material, obstacle, spec)
    if not path.parent.is_dir():
        raise PalpateError(
            f"The folder {path.parent} does not exist.", "Create it, or name another file.", code="folder-missing"
        )
    with atomic_write(path, "Name another file.") as part:
        part.write_text(text)


def deck_text(mesh: Mesh, material: Material, obstacle: ObstacleSpec, spec: DeckSpec | None = None) -> str:
    """Return the deck of a press as text.

    Parameters
    ----------
    mesh
        Half or whole skin; a half one is written in the tilt plane (y, z), for any azimuth.
    material
        The elastomer.
    obstacle
        Tilt, azimuth, depth, depth step and contact law.
    spec
        Dialect, element and contact penalty.

    Raises
    ------
    PalpateError
        If the dialect lacks the element or the law, the obstacle moves laterally, or it would touch the clamped rim
        first.
    """
    spec = spec or DeckSpec()
    if spec.dialect is Dialect.CALCULIX and spec.element is DeckElement.SHELL:
        raise PalpateError(
            "CalculiX converts shells to one layer of solids, 18 to 26 % too stiff here.",
            "Write the calculix deck with --element solid, or the shell for --dialect abaqus.",
            code="deck-shell-stiff",
        )
    depths = deck_depths(mesh, obstacle)
    parts = deck_mesh(mesh, spec.dialect, spec.element)
    plate = deck_wall(mesh, obstacle, len(parts.elements), spec.dialect)
    lines = [
        *_header(mesh, material, obstacle, spec),
        *mesh_lines(parts),
        *wall_lines(plate, spec.dialect),
        *material_lines(material, spec.dialect),
        *_sections(mesh, spec),
        *contact_lines(obstacle, spec),
        *boundary_lines(spec, half=not mesh.spec.whole),
        *time_point_lines(depths),
        *step_lines(spec, depths, obstacle.approach_axis(mesh)),
    ]
    return "\n".join(lines) + "\n"


def deck_depths(mesh: Mesh, obstacle: ObstacleSpec) -> list[float]:
    """Return the depths in mm of the increments of a deck, up to contact of the wall with the clamped rim."""
    return increment_depths(obstacle, min(obstacle.depth, obstacle.clamp_depth(mesh)))


def _header(mesh: Mesh, material: Material, wall: ObstacleSpec, spec: DeckSpec) -> Iterator[str]:
    skin = mesh.skin
    part = "whole skin" if mesh.spec.whole else "half skin x >= 0 (forces and energies of the whole are twice these)"
    yield "*HEADING"
    yield f"palpate {provenance()['palpate']}: {skin.name}, pressed by a rigid obstacle"
    yield "** Units: mm, N, MPa, mJ; pseudo-time is the depth of the wall in mm"
    top = "far end" if skin.hole else "apex"
    yield f"** Frame: origin in the middle of the base plane, z along the axis to the {top}"
    yield f"** Made by palpate {provenance()['palpate']} for {spec.dialect}, element {spec.element}"
    yield (
        f"** skin: {skin.name}, height {skin.height:g} mm, base radius {skin.base_radius:g} mm, thickness "
        f"{skin.thickness:g} mm (inner radius {skin.radius:.6g} mm); {part}"
    )
    yield f"** mesh: {mesh.spec.model_dump_json()}"
    yield f"** material: {material.name}"
    yield (
        f"** obstacle: {ascii_label(wall)}, turned by {wall.turn_deg:g} deg about z, depth {wall.depth:g} mm, "
        f"an increment every {wall.depth_step:g} mm, contact {wall.contact_text}"
    )
    if not mesh.spec.whole:
        yield "** a half model lies in the tilt plane (y, z): rotate its results about z by the azimuth"


def _sections(mesh: Mesh, spec: DeckSpec) -> Iterator[str]:
    if spec.element is DeckElement.SHELL:
        yield "** Section: shell on the mid surface, thickness in mm, 5 points through it"
        yield "*SHELL SECTION, ELSET=DOME, MATERIAL=SILICONE"
        yield f"{mesh.skin.thickness:.10g}, 5"
        return
    yield "** Section: solid"
    yield f"*SOLID SECTION, ELSET={'SKIN' if mesh.filling else 'DOME'}, MATERIAL=SILICONE"
    if mesh.filling:
        yield "*SOLID SECTION, ELSET=GEL, MATERIAL=FILLING"
    if spec.dialect is Dialect.CALCULIX:
        yield "*MATERIAL, NAME=STIFF"
        yield "*ELASTIC"
        yield "1000., 0.3"
        yield "*SOLID SECTION, ELSET=WALL, MATERIAL=STIFF"
