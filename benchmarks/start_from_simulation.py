"""Few presses of a stand-in for a TacTip, from its simulation and from scratch.

    python benchmarks/start_from_simulation.py FOLDER 10 30 100

The stand-in is a twin whose motion by ring without tilt differs from that of the recording described in
`docs/other_laboratories.md` by 1.0 px RMS. The training starts from another material, gel, mesh and pin length. The
camera of the stand-in is tilted by 2° and rolled by 20°, with a lens between pinhole and equidistant, and its markers
have print errors. Its presses move up to 0.85 mm sideways and twist up to 2.5°, which the table does not state. It
counts depth from 0.9 mm after contact. Images are drawn by `tests/drawn_tactip.py`. Presses are kept in FOLDER: an
interrupted run resumes (eight presses, some 20 CPU-minutes; two trainings a row, one to two CPU-minutes each).
"""

from __future__ import annotations

import csv
import os
import sys
import time
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from drawn_tactip import draw_image
from palpate.core import ArtefactStore
from palpate.core.run import Progress
from palpate.datasets import read_recording
from palpate.design import Design, MarkerLayout, MarkerSpec, Skin
from palpate.fea import read_press
from palpate.learn import RecordingSpec, SimulatedStart, train_on_recording
from palpate.study import PressTask, Study
from palpate.surrogate import Twin, build_twin, twin_derivatives

STAND_IN = {
    "name": "start",
    "designs": {"heights": [19], "thicknesses": [1], "base_radius": 19, "skin": {"kind": "pinned", "pin": 1.5}},
    "material": {"name": "neo-hooke:0.98", "gel": "neo-hooke:0.061"},
    "mesh": {"cells": 8},
    "tilts_deg": [0, 8, 16, 25],
    "obstacle": {"depth": 6, "depth_step": 0.5, "contact": 1.0},
    "camera": {"width_px": 640, "height_px": 480, "fx_px": 500, "fy_px": 500, "cx_px": 320, "cy_px": 240},
}
START = STAND_IN | {
    "designs": STAND_IN["designs"] | {"skin": {"kind": "pinned", "pin": 2.0}},
    "material": {"name": "neo-hooke:0.40", "gel": "neo-hooke:0.09"},
    "mesh": {"cells": 9},
    "tilts_deg": [0, 7, 15, 25],
}
RINGS = (4.57, 9.06, 13.39, 17.50, 21.31, 24.75, 27.76, 30.31, 32.33, 33.81)
"""Diameters of the rings on the stand-in, mm: equal steps of the polar angle to 75°."""
TEST_SEED, TEST_IMAGES, ZERO_MM, DISTANCE_MM, FOCAL_PX = 7, 300, 0.9, 30.0, (313.4, 63.7)


def solve(data: dict[str, object], store: ArtefactStore) -> Twin:
    """Twin of a study's skin."""
    study = Study.model_validate(data)
    (skin,) = study.designs.skins()
    mesh = study.material.mesh(study.mesh)
    solver = study.solver.model_copy(update={"derivatives": twin_derivatives(filled=True)})
    found = []
    for tilt in study.tilts_deg:
        task = PressTask(design=study.design(skin), mesh=mesh, obstacle=study.obstacle_at(tilt), solver=solver)
        if store.find(task.recipe) is None:
            task.make(store)
        found.append(read_press(store.path(task.recipe)))
    return build_twin(found)


def place_pins(skin: Skin, misprint: float) -> np.ndarray:
    """Tips (m, 3) mm of the pins on a skin, with print errors of a deviation in mm."""
    (designed,) = Study.model_validate(STAND_IN).designs.skins()
    disc = designed.build().disc(Design(designed, MarkerSpec(ring_diameters=RINGS)).layout.positions)
    error = np.random.default_rng(0).normal(0.0, misprint / skin.base_radius, disc.shape)
    return skin.marked(disc + error)


def project(points: np.ndarray) -> np.ndarray:
    """Pixels of points in the skin's frame, by a camera of its own: tilted, rolled, between two lenses."""
    tilt, roll = np.radians(2.0), np.radians(20.0)
    turn = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    seen = (points - [0.3, 0.0, -DISTANCE_MM]) @ turn.T
    away = np.hypot(seen[..., 0], seen[..., 1])
    angle = np.arctan2(away, seen[..., 2])
    radius = FOCAL_PX[0] * np.tan(angle) + FOCAL_PX[1] * angle
    plane = seen[..., :2] * (radius / np.maximum(away, 1e-9))[..., None]
    return plane @ np.array([[np.cos(roll), np.sin(roll)], [-np.sin(roll), np.cos(roll)]]) + [211.0, 212.0]


def draw(folder: Path, twin: Twin, count: int, seed: int) -> Path:
    """Draw a recording of the stand-in."""
    if (folder / "poses.csv").exists():
        return folder
    folder.mkdir(parents=True, exist_ok=True)
    rng, noise = np.random.default_rng(seed), np.random.default_rng([seed, 2])
    markers = twin.with_markers(place_pins(twin.skin, 0.04))
    rest, rows = project(markers.places), [["image", "rx_deg", "ry_deg", "depth_mm"]]
    cv2.imwrite(str(folder / "rest.png"), draw_image(rest, np.full(len(rest), 5.2), noise))
    for number in range(count):
        tilt, azimuth, depth = (
            25.0 * np.sqrt(rng.random()),
            2.0 * np.pi * rng.random(),
            rng.uniform(1.0, 5.0) + ZERO_MM,
        )
        lateral = rng.uniform(-1, 1, 3) * [0.85, 0.85, 2.5]
        pose = np.array([tilt * np.cos(azimuth), tilt * np.sin(azimuth), depth])
        places = project(markers.evaluate(pose, 1.0, lateral=lateral).positions)
        cv2.imwrite(str(folder / f"{number}.png"), draw_image(places, np.full(len(rest), 5.2), noise))
        label = pose - [0.0, 0.0, ZERO_MM] + noise.normal(size=3) * [0.03, 0.03, 0.01]
        rows.append([f"{number}.png", *(f"{value:.4f}" for value in label)])
    with (folder / "poses.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return folder


def main(folder: Path, counts: list[int]) -> None:
    """Print a row of CSV for each number of presses, draw and start."""
    store = ArtefactStore(folder / "presses")
    twin, unit = solve(START, store), solve(STAND_IN, store)
    study = Study.model_validate(START)
    layout = MarkerLayout(place_pins(twin.skin, 0.0), 0.9)
    design = replace(study.design(next(iter(study.designs.skins()))), markers=layout)
    start = SimulatedStart("start", design, twin)
    test = draw(folder / "test", unit, TEST_IMAGES, TEST_SEED)
    images = [
        (cv2.imread(str(test / name), 0), pose) for name, *pose in list(csv.reader((test / "poses.csv").open()))[1:]
    ]
    print("presses,draw,start,chosen,rx_deg,ry_deg,depth_mm,inside_rx,inside_ry,inside_depth,cpu_s")
    for count in counts:
        for number in (1, 2):
            recording = draw(folder / f"{count}_{number}", unit, count, 100 * number + count)
            for name, begin in (("simulation", start), ("scratch", None)):
                before = time.process_time() + sum(os.times()[2:4])
                spec, own = RecordingSpec(estimators="ridge", threads=1), ArtefactStore(recording / name)
                found = train_on_recording(read_recording(recording), spec, own, Progress(), begin)
                spent = time.process_time() + sum(os.times()[2:4]) - before
                read = [(found.model.read(image)[0], np.array(pose, float)) for image, pose in images]
                errors = np.array([np.ravel(one.pose) - pose for one, pose in read])
                inside = np.mean(np.abs(errors) <= [np.ravel(one.half_width) for one, _ in read], axis=0)
                figures = [*(f"{x:.3f}" for x in np.sqrt(np.mean(errors**2, axis=0))), *(f"{x:.2f}" for x in inside)]
                print(",".join([str(count), str(number), name, found.best, *figures, f"{spent:.0f}"]), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), [int(one) for one in sys.argv[2:]])
