"""Press skins of every kind, hollow and filled, by palpate and by CalculiX on the same mesh, and compare every image.

    python benchmarks/skins_against_calculix.py RESULTS.csv             every kind of skin
    python benchmarks/skins_against_calculix.py RESULTS.csv published   every published sensor

Frictionless, 5°, 91 markers (published sensors: their own markers, half of their depth, pads 2°, a barrel from its
side at 92°), 20-node bricks (C3D20R) in CalculiX where palpate has 27-node ones, the pole of the mesh under the point
of first touch in both. Forces are those along the way of the wall. What is flat or filled has more cells around
(`core`), a barrel along, and a filled one a contact that is stiffer by its wall's modulus in CalculiX:
docs/theory/skins.md says why. A skin is written when both programs have finished it, so a stopped run goes on where
it was.
"""

import csv
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from palpate.core import FloatArray
from palpate.design import ConeSpec, DomeSpec, EllipsoidSpec, MarkerSpec, Skin, SkinSpec, SplineSpec, place_markers
from palpate.fea import DeckSpec, Dialect, ObstacleSpec, Press, WallSpec, solve_press, solve_press_calculix
from palpate.fea.calculix import CalculixSpec
from palpate.material import Material, get_material
from palpate.mesh import MeshSpec, centre_mesh, mesh_skin
from palpate.study import plan_study, read_study

SILICONE = get_material("zaid_2024_ecoflex_00_30")
RUBBER = get_material("neo-hooke:0.1")
HOLLOW, FLAT, FILLED = MeshSpec(core=2), MeshSpec(cells=32, core=4), MeshSpec(cells=14, core=4, filled=True)
TUBE = MeshSpec(cells=48, core=4)
CASES: dict[str, tuple[SkinSpec, Material, MeshSpec, float]] = {
    "cone": (ConeSpec(height=22, base_radius=18, edge_radius=8), SILICONE, HOLLOW, 6.0),
    "cone with a flat": (ConeSpec(height=18, base_radius=18, flat_radius=5, edge_radius=8), SILICONE, FLAT, 6.0),
    "finger": (ConeSpec(height=25, base_radius=12, edge_radius=12), SILICONE, HOLLOW, 6.0),
    "spline": (SplineSpec(height=18, points=((0.5, 0.92), (0.85, 0.55))), SILICONE, HOLLOW, 6.0),
    "tapered": (EllipsoidSpec(height=18, thickness=1.5, aspect=0.9, taper=1.8), SILICONE, HOLLOW, 3.2),
    "filled dome": (DomeSpec(thickness=1), replace(RUBBER, gel=get_material("neo-hooke:0.01")), FILLED, 3.2),
}
PUBLISHED = "hemisphere_397", "small_tactip", "tactip_127", "filled_hemisphere", "gel_pad", "flat_pad", "barrel"
ALIKE = {"tactip_127": "tactip_331"}
"""Published sensors of the same wall and gel, but other pins: one press serves both."""
SOFT, STIFFER = 1.0, 50.0
"""Stiffness of the contact in CalculiX, MPa/mm, and of a filled skin over the shear modulus of its wall, 1/mm."""
CONFINED = 1000.0
"""The same of a published skin with a wall as soft as its gel, which comes under many times that as pressure."""
SOFT_WALL_MPA = 1.0
"""Shear modulus below which a wall is as soft as a gel."""
PAD_MM = 5.0
"""Height below which a skin is a pad."""
IMAGES = 4
"""Images of a press of a published sensor."""
COLUMNS = ["skin", "cells", "depth_mm", "force_palpate_n", "force_calculix_n", "force_deviation_percent"]
COLUMNS += ["energy_deviation_percent", "marker_rms_percent", "marker_max_percent", "cpu_palpate_s", "cpu_calculix_s"]


@dataclass(frozen=True)
class Case:
    """What both programs press."""

    skin: Skin
    material: Material
    mesh: MeshSpec
    wall: ObstacleSpec
    markers: Mapping[str, tuple[Skin, FloatArray]]
    """Skin with its pins and markers (n, 3) mm by the name of the sensor that has them."""
    penalty: float
    """Stiffness of the contact in CalculiX, MPa/mm."""


def skin_case(name: str) -> Case:
    spec, material, mesh, depth = CASES[name]
    wall = WallSpec(tilt_deg=5, contact="frictionless", depth=depth)
    skin = spec.build()
    penalty = STIFFER * material.law.shear_modulus if mesh.filled else SOFT
    return Case(skin, material, mesh, wall, {name: _marked(skin, MarkerSpec(count=91))}, penalty)


def published_case(name: str) -> Case:
    """One press of a study of the package, its mesh refined around (docs/theory/skins.md)."""
    designs = {one: plan_study(read_study(one)).designs[0].dataset for one in (name, ALIKE.get(name, name))}
    press = designs[name].presses[0]
    skin = press.design.skin
    mesh = FILLED if press.mesh.filled else TUBE if skin.hole else HOLLOW
    markers = {one: _marked(design.design.skin, design.design.markers) for one, design in designs.items()}
    tilt, depth = 92.0 if press.obstacle.sideways else 5.0 if skin.height > PAD_MM else 2.0, press.obstacle.depth / 2
    travel = {"tilt_deg": tilt, "contact": "frictionless", "depth": depth, "depth_step": depth / IMAGES}
    modulus = press.design.material.law.shear_modulus
    penalty = modulus * (CONFINED if modulus < SOFT_WALL_MPA else STIFFER) if mesh.filled else SOFT
    return Case(skin, press.design.material, mesh, press.obstacle.model_copy(update=travel), markers, penalty)


def _marked(skin: Skin, markers: MarkerSpec) -> tuple[Skin, FloatArray]:
    return skin, place_markers(skin, markers).positions


def compare(case: Case) -> list[dict[str, object]]:
    skin, material, meshing, wall = case.skin, case.material, case.mesh, case.wall
    mesh = mesh_skin(skin, meshing)
    mesh = centre_mesh(mesh, wall.at_first_contact(mesh)[1])
    deck = DeckSpec(dialect=Dialect.CALCULIX, penalty=case.penalty)
    ours = solve_press(mesh, material, wall)
    theirs = solve_press_calculix(mesh, material, wall, CalculixSpec(deck=deck))
    return [row for name, marked in case.markers.items() for row in rows_of(name, ours, theirs, *marked)]


def rows_of(name: str, ours: Press, theirs: Press, skin: Skin, markers: FloatArray) -> list[dict[str, object]]:
    ours, theirs = (replace(press, mesh=replace(press.mesh, skin=skin)) for press in (ours, theirs))
    count = min(len(ours.depth), len(theirs.depth))
    force, other = _thrust(ours), _thrust(theirs)
    away = np.linalg.norm(ours.positions(markers)[:count] - theirs.positions(markers)[:count], axis=-1)
    return [
        {
            "skin": name,
            "cells": len(ours.mesh.cells),
            "depth_mm": round(float(ours.depth[k]), 4),
            "force_palpate_n": f"{force[k]:.6f}",
            "force_calculix_n": f"{other[k]:.6f}",
            "force_deviation_percent": f"{100 * (force[k] / other[k] - 1):.3f}",
            "energy_deviation_percent": f"{100 * (ours.energy[k] / theirs.energy[k] - 1):.3f}",
            "marker_rms_percent": f"{100 * np.sqrt((away[k] ** 2).mean()) / ours.depth[k]:.3f}",
            "marker_max_percent": f"{100 * away[k].max() / ours.depth[k]:.3f}",
            "cpu_palpate_s": round(ours.cpu_s, 1),
            "cpu_calculix_s": round(theirs.cpu_s, 1),
        }
        for k in range(1, count)
        if abs(ours.depth[k] - theirs.depth[k]) < 1e-6
    ]


def _thrust(press: Press) -> FloatArray:
    """Force (n,) N against the way of the obstacle."""
    return np.asarray(press.force @ press.obstacle.turn(press.mesh) @ press.obstacle.approach_axis(press.mesh))


def main() -> None:
    path = Path(sys.argv[1])
    rows = list(csv.DictReader(path.open())) if path.exists() else []
    published = sys.argv[2:] == ["published"]
    for name in PUBLISHED if published else CASES:
        if name not in {row["skin"] for row in rows}:
            rows += compare(published_case(name) if published else skin_case(name))
            with path.open("w", newline="") as file:
                table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                table.writeheader()
                table.writerows(rows)
            print(f"{name} done", flush=True)


if __name__ == "__main__":
    main()
