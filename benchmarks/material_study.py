"""What the material of a dome changes: force, marker map and angle. H20 T2, 169 markers, no slip, the default mesh.

    python benchmarks/material_study.py --workers 2 --out docs/results/materials

Seven materials are pressed at tilts 0, 5 and 10°: the paper's, half and twice as stiff, a neo-Hookean one of the same
initial stiffness, our fits to the public tests of Ecoflex 00-30 (another batch and bench) and Dragon Skin 10, and the
paper's with a bulk modulus of 20 mu, as solid elements of Abaqus/Explicit take where none is given.

Against the paper's material: the force; how far the markers are in the image at the same pose; the angle that a
least-squares estimator of the paper's material reads wrongly for that; and each material's own limit of the angle.
"""

from __future__ import annotations

import argparse
import csv
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

RAW = Path(__file__).parents[1] / "tests/unit/material/data/marechal_2020/Ecoflex 00-30.csv"
TILTS, REACH_DEG, MARKERS, POSES = (0.0, 5.0, 10.0), 10.0, 169, 48
PAPER = "zaid_2024_ecoflex_00_30"
BULK_RATIO = {"paper, K/mu 20": 20.0}
MATERIALS = {
    "paper": PAPER,
    "half": "yeoh:0.0070578,0.0000553,0.0000024",
    "twice": "yeoh:0.0282312,0.0002212,0.0000096",
    "neo-hooke": "neo-hooke:0.0141156",
    "shared 00-30": "marechal_2020_ecoflex_00_30",
    "shared DS 10": "marechal_2020_dragon_skin_10",
    "paper, K/mu 20": PAPER,
}
FORCES = ["material", "tilt_deg", "depth_mm", "force_n", "force_over_paper", "branch"]
IMAGES = [
    "material",
    "depth_mm",
    "markers_rms_px",
    "markers_max_px",
    "bias_rms_deg",
    "bias_max_deg",
    "depth_bias_rms_mm",
    "bound_deg",
    "limit_over_paper",
]


def solve(case: tuple[str, float]) -> tuple[str, float, Any]:
    """Press one material at one tilt."""
    from palpate.design import DomeSpec, build_skin
    from palpate.fea import WallSpec, solve_press
    from palpate.material import get_material
    from palpate.mesh import mesh_skin

    name, tilt = case
    material = get_material(MATERIALS[name])
    material = material.with_bulk_ratio(BULK_RATIO.get(name, material.bulk_ratio))
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=2)))
    return name, tilt, solve_press(mesh, material, WallSpec(tilt_deg=tilt, contact="no-slip"))


def tabulate_forces(presses: dict[str, list[Any]]) -> list[dict[str, Any]]:
    """Force of every image beside that of the paper's material."""
    import numpy as np

    rows = []
    for name, runs in presses.items():
        for tilt, press, base in zip(TILTS, runs, presses["paper"], strict=True):
            force, reference = np.linalg.norm(press.force, axis=1), np.linalg.norm(base.force, axis=1)
            for at in range(1, min(len(force), len(reference))):
                values = (name, tilt, press.depth[at], force[at], force[at] / reference[at], press.branch[at])
                rows.append(dict(zip(FORCES, values, strict=True)))
    return rows


def tabulate_images(presses: dict[str, list[Any]]) -> list[dict[str, Any]]:
    """Marker maps, misread angles and limits of every depth from 2.4 mm on."""
    import numpy as np

    from palpate.camera import CameraSpec, build_camera
    from palpate.datasets import DatasetSpec, sample_poses
    from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
    from palpate.learn import compute_error_bounds
    from palpate.surrogate import build_field, image_jacobian

    camera = build_camera(CameraSpec())
    spec = DatasetSpec(max_tilt_deg=REACH_DEG)
    layout = place_markers(build_skin(DomeSpec(height=20, thickness=2)), MarkerSpec(count=MARKERS))
    poses = sample_poses(DatasetSpec(n_presses=POSES, max_tilt_deg=REACH_DEG))
    fields = {name: build_field(runs, layout) for name, runs in presses.items()}
    limits = {
        name: {item.depth_mm: item for item in compute_error_bounds(f, camera, spec)} for name, f in fields.items()
    }
    rows = []
    for name, field in fields.items():
        for depth, limit in limits[name].items():
            at = int(np.argmin(np.abs(field.depths_mm - depth)))
            seen, base = (camera.project(f.positions(*poses.T, at)) for f in (field, fields["paper"]))
            jacobian = image_jacobian(fields["paper"], camera, poses, at)
            shift = seen - base
            known = np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(shift).all(axis=(1, 2))
            flat = shift[known].reshape(known.sum(), -1)
            misread = np.array(
                [np.linalg.lstsq(j, s, rcond=None)[0] for j, s in zip(jacobian[known], flat, strict=True)]
            )
            distance = np.linalg.norm(shift[known], axis=-1)
            angle = np.abs(misread[:, :2])
            values = (
                name,
                depth,
                np.sqrt(np.mean(distance**2)),
                distance.max(),
                np.sqrt(np.mean(angle**2)),
                angle.max(),
                np.sqrt(np.mean(misread[:, 2] ** 2)),
                limit.least_squares_deg,
                limit.least_squares_deg / limits["paper"][depth].least_squares_deg,
            )
            rows.append(dict(zip(IMAGES, values, strict=True)))
    return rows


def write(path: Path, columns: list[str], rows: list[dict[str, Any]]) -> None:
    """Write rows as CSV, numbers to five digits."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({key: value if isinstance(value, str) else f"{value:.5g}" for key, value in row.items()})


def draw_sources(path: Path) -> None:
    """Draw the two sources of Ecoflex 00-30: the paper's law, the shared test, its fit, and the corrected strain."""
    import numpy as np
    from matplotlib.figure import Figure

    from palpate.material import Mode, get_material, read_test_file, trace_curve

    figure = Figure(figsize=(5.2, 3.8), layout="constrained")
    axis = figure.subplots()
    stretch = np.linspace(1, 5, 100)
    for name, label, colour in (
        (PAPER, "Zaid 2024", "#c1272d"),
        (MATERIALS["shared 00-30"], "our fit to Marechal 2020", "#1f4e8c"),
    ):
        nominal = trace_curve(get_material(name), Mode.UNIAXIAL, stretch).nominal
        axis.plot(stretch, 1e3 * nominal, color=colour, label=label)
    (test,) = read_test_file(RAW)
    for factor, label, style in ((1.0, "Marechal 2020, as published", "."), (0.56, "the same, strain × 0.56", "x")):
        along = 1 + factor * (test.stretch - 1)
        shown = np.flatnonzero(along <= 5)[:: round(6 / factor)]
        axis.plot(along[shown], 1e3 * test.nominal[shown], style, color="0.4", markersize=5, label=label)
    axis.set_xlabel("stretch")
    axis.set_ylabel("nominal stress (kPa)")
    axis.set_title("Two sources of Ecoflex 00-30, tension", fontsize=10)
    axis.legend(fontsize=8, frameon=False)
    figure.savefig(path, dpi=160)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("docs/results/materials"))
    given = parser.parse_args()
    for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[variable] = "1"
    presses: dict[str, list[Any]] = {name: [] for name in MATERIALS}
    cases = [(name, tilt) for name in MATERIALS for tilt in TILTS]
    with ProcessPoolExecutor(given.workers, mp_context=get_context("spawn")) as pool:
        for name, tilt, press in pool.map(solve, cases):
            presses[name].append(press)
            print(
                f"{name} {tilt:g} deg: {press.ended} at {press.ended_depth:.2f} mm, {press.cpu_s:.0f} s", flush=True
            )
    given.out.mkdir(parents=True, exist_ok=True)
    draw_sources(given.out / "ecoflex_00_30.png")
    forces, images = tabulate_forces(presses), tabulate_images(presses)
    write(given.out / "forces.csv", FORCES, forces)
    write(given.out / "images.csv", IMAGES, images)
    for row in images:
        print(
            ", ".join(
                f"{key} {value if isinstance(value, str) else format(value, '.4g')}" for key, value in row.items()
            )
        )


if __name__ == "__main__":
    main()
