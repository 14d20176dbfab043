"""Tilt error of a sensor that is pressed over holes, after training with and without them.

H 20 T 2, 37 markers, the camera of the paper, noise of 0.1 px. Two networks are trained: on presses by a flat wall,
and on presses by the wall and by plates with holes of 2 to 10 mm, up to 3 mm off the axis along and across the slope
(`dataset.randomise.obstacles`). Both read presses of plates that neither has seen: other tilts, diameters and
offsets, at azimuths all around. One row a network, diameter and offset: RMSE of rx and ry, mean error along the slope
(bias), and added RMSE: that of the network minus that of the first one under the flat wall.

    python benchmarks/plates_with_holes.py FOLDER --contacts no-slip --out docs/results/sensor/plates_with_holes.csv

Presses are kept in FOLDER; an interrupted run resumes.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from palpate.camera import Camera, CameraSpec, build_camera
from palpate.datasets import Dataset, DatasetSpec, PerturbedPresses, RandomisationSpec, draw_jitter, generate_dataset
from palpate.design import DomeSpec, MarkerLayout, MarkerSpec, build_skin, place_markers
from palpate.fea import ObstacleSpec, Press, WallSpec, obstacle_from_data, read_press, solve_press, write_press
from palpate.learn import Estimator, TrainingSpec, train
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin

SKIN = DomeSpec(height=20, thickness=2)
TILTS = (0.0, 3.0, 6.0, 9.0, 12.0)
OFFSETS = [*({"offset": off} for off in (-3.0, -1.5, 0.0, 1.5, 3.0)), {"offset_across": -2.5}, {"offset_across": 2.5}]
HOLES = [{"kind": "plate", "hole_diameter": wide, **off} for wide, off in product((2.0, 4.0, 7.0, 10.0), OFFSETS)]
TEST_TILTS = (2.0, 7.0, 11.0)
TEST_HOLES = [
    {"hole_diameter": wide, "offset": up, "offset_across": aside}
    for wide, (up, aside) in product((3.0, 5.5, 8.5), ((0.0, 0.0), (2.25, 0.0), (-2.25, 0.0), (0.0, 2.0), (2.1, 2.1)))
]
NOISE_PX, DEPTH, STEP, FROM_MM = 0.1, 6.0, 0.4, 2.0
AZIMUTHS_DEG = np.arange(0.0, 360.0, 15.0)
COLUMNS = [
    "contact",
    "trained_on",
    "hole_diameter_mm",
    "offset_mm",
    "across_mm",
    "images",
    "rmse_deg",
    "bias_deg",
    "added_rmse_deg",
]


def solve(folder: Path, obstacle: ObstacleSpec) -> Press:
    """A press, from the folder if it is there."""
    name = "_".join(f"{key}={value}" for key, value in obstacle.model_dump(exclude_unset=True).items())
    path = folder / f"{name}.h5"
    if not path.is_file():
        mesh = mesh_skin(build_skin(SKIN), MeshSpec(whole=not obstacle.mirrored))
        write_press(path, solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), obstacle))
    return read_press(path)


def over_plate(press: Press, layout: MarkerLayout, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Images (n, m, 2) px of a press turned to all azimuths, and their poses (n, 3)."""
    kept = (press.depth >= FROM_MM) & (press.branch == "flat")
    images, poses = [], []
    for azimuth in np.radians(AZIMUTHS_DEG):
        c, s = np.cos(azimuth), np.sin(azimuth)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        moved = press.positions(layout.positions @ turn)[kept] @ turn.T  # the skin is of revolution
        images += [camera.project(one) for one in moved]
        poses += [[press.obstacle.radial * c, press.obstacle.radial * s, depth] for depth in press.depth[kept]]
    return np.array(images), np.array(poses)


def row(estimator: Estimator, images: np.ndarray, poses: np.ndarray) -> dict[str, float]:
    """Errors of an estimator on images with noise."""
    noisy = draw_jitter(images, NOISE_PX, np.random.default_rng(0))
    off = (estimator.predict(noisy) - poses)[:, :2]
    along = poses[:, :2] / np.linalg.norm(poses[:, :2], axis=1)[:, None]
    return {
        "images": len(images),
        "rmse_deg": round(float(np.sqrt(np.mean(off**2))), 4),
        "bias_deg": round(float((off * along).sum(axis=1).mean()), 4),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--contacts", nargs="+", default=["0.5", "no-slip"])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("plates_with_holes.csv"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    layout, camera = place_markers(build_skin(SKIN), MarkerSpec(count=37)), build_camera(CameraSpec())
    rows = []
    for contact in given.contacts:
        travel = {"depth": DEPTH, "depth_step": STEP, "contact": contact if contact == "no-slip" else float(contact)}
        flat = [WallSpec(tilt_deg=tilt, **travel) for tilt in TILTS]
        holes = [[obstacle_from_data({**hole, **travel, "tilt_deg": tilt}) for tilt in TILTS] for hole in HOLES]
        level = [WallSpec(tilt_deg=tilt, **travel) for tilt in TEST_TILTS]
        tests = [
            [obstacle_from_data({"kind": "plate", **hole, **travel, "tilt_deg": tilt}) for tilt in TEST_TILTS]
            for hole in TEST_HOLES
        ]
        every = [*flat, *level, *(one for group in (*holes, *tests) for one in group)]
        with ProcessPoolExecutor(given.workers, multiprocessing.get_context("spawn")) as pool:
            solved = dict(zip(map(str, every), pool.map(partial(solve, given.folder), every), strict=True))
        spec = DatasetSpec(jitter_px=NOISE_PX, dropped_images=4, n_presses=2400)
        varied = spec.model_copy(update={"randomise": RandomisationSpec(obstacles=tuple(HOLES))})
        datasets: dict[str, Dataset] = {
            "wall": generate_dataset([solved[str(one)] for one in flat], layout, camera, spec),
            "wall and holes": generate_dataset(
                [solved[str(one)] for one in flat],
                layout,
                camera,
                varied,
                PerturbedPresses(obstacles=tuple([solved[str(one)] for one in group] for group in holes)),
            ),
        }
        base = 0.0
        for name, dataset in datasets.items():
            estimator = train(dataset, TrainingSpec())
            for hole, group in zip([{}, *TEST_HOLES], [level, *tests], strict=True):
                pairs = [over_plate(solved[str(one)], layout, camera) for one in group]
                errors = row(estimator, *(np.concatenate(each) for each in zip(*pairs, strict=True)))
                base = base or errors["rmse_deg"]
                place = [hole.get(key, "") for key in ("hole_diameter", "offset", "offset_across")]
                names = zip(COLUMNS, [contact, name, *place], strict=False)
                rows.append({**dict(names), **errors, "added_rmse_deg": round(errors["rmse_deg"] - base, 4)})
                print(rows[-1], flush=True)
        with given.out.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
