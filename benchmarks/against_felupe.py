"""Press one dome by palpate and by FElupe on the same 27-node bricks, and compare force, markers and cost.

    python benchmarks/against_felupe.py RESULT.csv

FElupe (GPL, not a dependency of palpate) is installed into an environment of its own under build/felupe and runs as a
process of its own. It presses frictionless, node by node, by a penalty, in steps of 0.1 mm to `DEPTH_MM`.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import venv
from pathlib import Path

import numpy as np

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import locate_inner, mesh_skin
from palpate.mesh.hexahedron import CORNERS

FOLDER = Path("build/felupe")
PACKAGES = ["felupe>=11,<12", "tensortrax", "pypardiso"]
STEP_MM, DEPTH_MM = 0.1, 8.0
PENALTY = 60.0
"""Penalty over E/T times the area of a node: as stiff as palpate's."""
EDGES = [1, 5, 7, 3, 19, 23, 25, 21, 9, 11, 17, 15]
FACES, MIDDLE = [12, 14, 10, 16, 4, 22], [13]
"""palpate's lexicographic nodes in VTK's order of a 27-node brick: corners, edges, faces, middle."""
COLUMNS = [
    "depth_mm",
    "force_palpate_n",
    "force_felupe_n",
    "force_deviation_percent",
    "marker_rms_mm",
    "marker_max_mm",
]


def main() -> None:
    dome = build_skin(DomeSpec(height=20, thickness=2))
    mesh, material = mesh_skin(dome), get_material("zaid_2024_ecoflex_00_30")
    wall = WallSpec(tilt_deg=5, contact="frictionless", depth=DEPTH_MM)
    solve_press(mesh, material, wall.model_copy(update={"depth": 0.8}))  # compile
    ours = solve_press(mesh, material, wall)
    theirs = solve_by_felupe(ours)
    layout = place_markers(dome, MarkerSpec(count=169)).positions
    with Path(sys.argv[1]).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for row in compare(ours, theirs, layout):
            writer.writerow([f"{value:.4g}" for value in row])
            print(*(f"{value:.4g}" for value in row))
    print(f"palpate {ours.cpu_s:.1f} CPU-s, {ours.newton_iterations} iterations, {ours.unknowns} unknowns")
    print(f"FElupe {theirs['cpu_s']:.1f} CPU-s, {theirs['iterations']} iterations, {theirs['unknowns']} unknowns")
    print(theirs["failure"] or "FElupe reached the full depth.")


def solve_by_felupe(press: Press) -> dict[str, np.ndarray]:
    """Press the same mesh by FElupe, to the same images."""
    mesh, material = press.mesh, press.material
    wall = press.obstacle
    assert isinstance(wall, WallSpec)
    normal = wall.normal(mesh)
    outer = np.unique(mesh.outer_faces)
    area = np.pi * mesh.skin.outer_radius * (mesh.skin.height + mesh.skin.thickness) / len(outer)
    given, result = FOLDER / "press.npz", FOLDER / "result.npz"
    python = environment()
    np.savez(
        given,
        nodes=mesh.nodes,
        cells=mesh.cells[:, [*CORNERS, *EDGES, *FACES, *MIDDLE]],
        normal=-normal,
        touch=mesh.skin.support_point(normal),
        outer=outer,
        base=mesh.base,
        mirror=mesh.mirror,
        constants=[0.0141156, 0.0001106, 4.8e-06],
        bulk=material.bulk_modulus,
        penalty=PENALTY * material.young_modulus / mesh.skin.thickness * area,
        depth=press.depth[1:],
        steps=np.round(np.arange(1, round(DEPTH_MM / STEP_MM) + 1) * STEP_MM, 9),
    )
    script = Path(__file__).with_name("felupe_press.py")
    subprocess.run([python, script, given, result], check=True)
    return dict(np.load(result))


def environment() -> Path:
    """Python of an environment with FElupe."""
    python = FOLDER / "bin" / "python"
    if not python.exists():
        venv.create(FOLDER, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    return python


def compare(ours: Press, theirs: dict[str, np.ndarray], layout: np.ndarray) -> list[list[float]]:
    """One row an image of both."""
    side = np.where(layout[:, :1] < 0, [-1, 1, 1], 1)
    moved = locate_inner(ours.mesh, layout * side).interpolate(theirs["displacement"]) * side
    rows = []
    for image, depth in enumerate(theirs["depth"]):
        if image == 0:
            continue
        force = ours.force[image, 2], theirs["force"][image]
        distance = np.linalg.norm(ours.positions(layout)[image] - layout - moved[image], axis=1)
        deviation = 100 * (force[0] / force[1] - 1)
        rows.append([depth, *force, deviation, np.sqrt((distance**2).mean()), distance.max()])
    return rows


if __name__ == "__main__":
    main()
