"""The virtual bench: rendered images of solved presses through the real chain, by degradation.

    python benchmarks/virtual_bench.py PRESSES MODEL.onnx [OUT.csv]

PRESSES is a folder of presses, of which those of H = 20, T = 2 mm are taken; MODEL an estimator of its 169 markers,
trained for the nominal camera. Every press is turned to azimuths that the training has not seen; images are rendered
with the degradations stated below, in the last cases by a camera that is not the nominal one, and go through
detection, naming, tracking, registration and the model. Nothing of the chain knows the truth.
"""

import csv
import sys
from pathlib import Path

import numpy as np

from palpate.camera import CameraSpec, RenderSpec, build_camera, edge_offsets, render
from palpate.core import generator
from palpate.design import MarkerSpec, place_markers, place_orientation_mark
from palpate.fea import read_press
from palpate.fea.press import azimuth_rotation
from palpate.learn import open_predictor
from palpate.sensor import Unit, open_sensor, run_sensor

DEGRADED = {
    "vignetting": 0.35,
    "unevenness": 0.2,
    "glare": 25.0,
    "blur_px": 0.8,
    "noise": 3.0,
    "dirt": 15,
    "rim": True,
}
CAMERA = {"offset_x": 0.3, "offset_y": -0.2, "distance": 48.4, "tilt_x_deg": 0.6, "tilt_y_deg": -0.4, "roll_deg": 7.0}
CASES = {
    "clean, nominal camera": ({}, {}),
    "degraded, nominal camera": (DEGRADED, {}),
    "degraded, camera offset, tilted and rolled": (DEGRADED, CAMERA),
    "noise 3 only": ({"noise": 3.0, "blur_px": 0.8}, {}),
}


def edges_on(dome, centres, diameter):
    """Edges (m, k, 3) of dots on the undeformed inner sphere."""
    middle = np.array([0, 0, dome.center_z])
    normals = (centres - middle) / dome.radius
    first = np.cross(normals, np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normals, first)
    flat = edge_offsets(diameter / 2)
    arms = centres[:, None] + flat[:, :1] * first[:, None] + flat[:, 1:] * second[:, None] - middle
    return middle + dome.radius * arms / np.linalg.norm(arms, axis=-1, keepdims=True)


def images_of(press, azimuth, edges, camera, spoiled, seed):
    turn = azimuth_rotation(azimuth)
    flat = edges.reshape(-1, 3) @ turn  # the dome's markers, seen by a wall that is turned the other way
    for number, points in enumerate(press.positions(flat)):
        moved = (points @ turn.T).reshape(edges.shape)
        yield render(camera, moved, RenderSpec(**spoiled, seed=seed + number))


def play(presses, predictor, spoiled, pose, azimuths):
    dome = presses[0].mesh.dome
    layout = place_markers(dome, MarkerSpec(count=169))
    points = np.vstack([layout.positions, place_orientation_mark(dome, layout)])
    edges, camera, rng = (
        edges_on(dome, points, layout.diameter),
        build_camera(CameraSpec(**pose)),
        generator(0, "bench"),
    )
    rows, late = [], []
    for press in presses:
        for _ in range(azimuths):
            azimuth = float(rng.uniform(0, 360))
            images = list(images_of(press, azimuth, edges, camera, spoiled, int(rng.integers(1 << 30))))
            sensor = open_sensor(images[:1], Unit(dome, layout), predictor)
            angle = np.radians(azimuth + press.wall.azimuth_deg)
            truth = press.wall.tilt_deg * np.array([np.cos(angle), np.sin(angle)])
            for depth, reading in zip(press.depth, run_sensor(sensor, images), strict=True):
                late.append(reading.latency_ms)
                if depth >= 2.4 - 1e-9:
                    rows.append(
                        [
                            reading.rx_deg - truth[0],
                            reading.ry_deg - truth[1],
                            reading.depth_mm - depth,
                            len(reading.flags),
                        ]
                    )
    return np.array(rows), np.array(late)


def main():
    presses = [read_press(path) for path in sorted(Path(sys.argv[1]).rglob("*.h5"))]
    presses = [p for p in presses if (p.mesh.dome.height, p.mesh.dome.thickness) == (20, 2) and p.wall.tilt_deg > 0]
    predictor = open_predictor(Path(sys.argv[2]))
    table = [
        ["case", "images", "component", "RMSE", "MAE", "max", "SD", "flagged", "latency P50 ms", "latency P99 ms"]
    ]
    for case, (spoiled, pose) in CASES.items():
        errors, late = play(presses, predictor, spoiled, pose, azimuths=2)
        for column, name in enumerate(("roll deg", "pitch deg", "depth mm")):
            e = errors[:, column]
            figures = [np.sqrt(np.mean(e**2)), np.abs(e).mean(), np.abs(e).max(), e.std()]
            rest = [f"{np.mean(errors[:, 3] > 0):.3f}", *(f"{v:.2f}" for v in np.percentile(late, [50, 99]))]
            table.append([case, len(errors), name, *(f"{value:.3f}" for value in figures), *rest])
            print(*table[-1], sep=" · ", flush=True)
    if len(sys.argv) > 3:
        with open(sys.argv[3], "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows(table)


if __name__ == "__main__":
    main()
