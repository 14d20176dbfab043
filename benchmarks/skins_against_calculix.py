"""Press skins of every kind, hollow and filled, by palpate and by CalculiX on the same mesh, and compare every image.

    python benchmarks/skins_against_calculix.py RESULTS.csv

Frictionless, 5°, 91 markers, 20-node bricks (C3D20R) in CalculiX where palpate has 27-node ones, the pole of the mesh
under the point of first touch in both. What is flat or filled has more cells around (`core`), and a filled one a
contact ten times stiffer in CalculiX: docs/theory/skins.md says why. A skin is written when both programs have
finished it, so a stopped run goes on where it was.
"""

import csv
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from palpate.deck import DeckSpec, Dialect, solve_press_calculix
from palpate.deck.calculix import CalculixSpec
from palpate.design import ConeSpec, DomeSpec, EllipsoidSpec, MarkerSpec, SkinSpec, SplineSpec, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.material import Material, get_material
from palpate.mesh import MeshSpec, centre_mesh, mesh_skin

SILICONE = get_material("zaid_2024_ecoflex_00_30")
RUBBER = get_material("neo-hooke:0.1")
HOLLOW, FLAT, FILLED = MeshSpec(core=2), MeshSpec(cells=32, core=4), MeshSpec(cells=14, core=4, filled=True)
CASES: dict[str, tuple[SkinSpec, Material, MeshSpec, float]] = {
    "cone": (ConeSpec(height=22, base_radius=18, edge_radius=8), SILICONE, HOLLOW, 6.0),
    "cone with a flat": (ConeSpec(height=18, base_radius=18, flat_radius=5, edge_radius=8), SILICONE, FLAT, 6.0),
    "finger": (ConeSpec(height=25, base_radius=12, edge_radius=12), SILICONE, HOLLOW, 6.0),
    "spline": (SplineSpec(height=18, points=((0.5, 0.92), (0.85, 0.55))), SILICONE, HOLLOW, 6.0),
    "tapered": (EllipsoidSpec(height=18, thickness=1.5, aspect=0.9, taper=1.8), SILICONE, HOLLOW, 3.2),
    "filled dome": (DomeSpec(thickness=1), replace(RUBBER, gel=get_material("neo-hooke:0.01")), FILLED, 3.2),
}
COLUMNS = ["skin", "cells", "depth_mm", "force_palpate_n", "force_calculix_n", "force_deviation_percent"]
COLUMNS += ["energy_deviation_percent", "marker_rms_percent", "marker_max_percent", "cpu_palpate_s", "cpu_calculix_s"]


def compare(name: str) -> list[dict[str, object]]:
    spec, material, meshing, depth = CASES[name]
    skin = spec.build()
    mesh, wall = mesh_skin(skin, meshing), WallSpec(tilt_deg=5, contact="frictionless", depth=depth)
    mesh = centre_mesh(mesh, wall.at_touch(mesh)[1])
    deck = DeckSpec(dialect=Dialect.CALCULIX, penalty=10.0 if meshing.filled else 1.0)
    ours = solve_press(mesh, material, wall)
    theirs = solve_press_calculix(mesh, material, wall, CalculixSpec(deck=deck))
    markers = place_markers(skin, MarkerSpec(count=91)).positions
    count = min(len(ours.depth), len(theirs.depth))
    away = np.linalg.norm(ours.positions(markers)[:count] - theirs.positions(markers)[:count], axis=-1)
    return [
        {
            "skin": name,
            "cells": len(mesh.cells),
            "depth_mm": round(float(ours.depth[k]), 4),
            "force_palpate_n": f"{ours.force[k, 2]:.6f}",
            "force_calculix_n": f"{theirs.force[k, 2]:.6f}",
            "force_deviation_percent": f"{100 * (ours.force[k, 2] / theirs.force[k, 2] - 1):.3f}",
            "energy_deviation_percent": f"{100 * (ours.energy[k] / theirs.energy[k] - 1):.3f}",
            "marker_rms_percent": f"{100 * np.sqrt((away[k] ** 2).mean()) / ours.depth[k]:.3f}",
            "marker_max_percent": f"{100 * away[k].max() / ours.depth[k]:.3f}",
            "cpu_palpate_s": round(ours.cpu_s, 1),
            "cpu_calculix_s": round(theirs.cpu_s, 1),
        }
        for k in range(1, count)
        if abs(ours.depth[k] - theirs.depth[k]) < 1e-6
    ]


def main() -> None:
    path = Path(sys.argv[1])
    rows = list(csv.DictReader(path.open())) if path.exists() else []
    for name in CASES:
        if name not in {row["skin"] for row in rows}:
            rows += compare(name)
            with path.open("w", newline="") as file:
                table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
                table.writeheader()
                table.writerows(rows)
            print(f"{name} done", flush=True)


if __name__ == "__main__":
    main()
