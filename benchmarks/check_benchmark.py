"""Hold images of a benchmark's set against presses of their units solved anew, on another mesh, without a twin.

    palpate benchmark make -o results/benchmark
    python benchmarks/check_benchmark.py results/benchmark/set 4

Of each design so many images that teach are drawn at random, in the flat state. Left over are the noise drawn
with them, and what the twin behind the set is off.
"""

import sys
from pathlib import Path

import numpy as np
from palpate_benchmark import deviation_of, read_set

from palpate.camera import project_markers
from palpate.design import Design, build_skin, place_markers, wall_normal
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.simulation import SimulatedUnit

CELLS = 12


def main(folder: str, count: int) -> None:
    """Print, for each image, what dots moved, by how much they differ, and both forces."""
    benchmark = read_set(Path(folder))
    spec, table = benchmark.spec, benchmark.table("train")
    print("design,unit,tilt_deg,friction,depth_mm,moved_px,off_px,force_n,solved_n")
    for design in spec.designs:
        markers, skin = benchmark.markers("train", design.name), build_skin(design.skin)
        layout = place_markers(skin, design.marker_layout)
        rows = np.flatnonzero((table.design == design.name) & (table.branch == "flat"))
        for row in np.random.default_rng(0).permutation(rows)[:count]:
            rx, ry, depth, force, _, friction = table.labels[row]
            unit, tilt = int(table.unit[row]), float(np.hypot(rx, ry))
            built = deviation_of(spec, design, unit)
            scene = SimulatedUnit(Design.of_skin(skin, layout, spec.camera), built, spec.render)
            azimuth = float(np.degrees(np.arctan2(ry, rx)))
            wall = WallSpec(tilt_deg=tilt, azimuth_deg=azimuth, depth=depth, depth_step=0.8, contact=friction)
            mesh = mesh_skin(build_skin(built.dome(design.skin)), MeshSpec(cells=CELLS))
            press = solve_press(mesh, built.material(get_material(spec.material)), wall)
            edges = press.positions(scene.edges[:-1].reshape(-1, 3))[-1].reshape(-1, *scene.edges.shape[1:])
            solved = project_markers(scene.camera, edges).centres
            noted = markers.markers_px[markers.image == table.image[row]][0]
            there = np.isfinite(noted).all(axis=1)
            moved = (noted - markers.rest_px[unit])[there]
            pressing = press.force[-1] @ wall_normal(np.radians(tilt), 0.0)
            figures = (np.sqrt((moved**2).mean()), np.sqrt(((solved - noted[there]) ** 2).mean()), force, pressing)
            shown = ",".join(f"{value:.4f}" for value in figures)
            print(f"{design.name},{unit},{tilt:.2f},{friction:.2f},{depth:.2f},{shown}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
