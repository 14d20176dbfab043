"""Noise of a dot's centre by its diameter in the image: palpate's detector on degraded images of the bench.

    python benchmarks/dot_noise.py [IMAGES] [OUT.csv]

A dome with 37 dots is photographed again and again, each time with the camera moved by parts of a pixel and with new
noise. What is found is held against the centroid of each dot's trace. `noise_px` is the spread about what a dot is
off on the average (root of the mean square over dots, each robust against specks of dirt), `constant_px` the spread
of these averages, which light and dirt make and which is the same wherever the dot hardly moves; `both_px` has both.
`bound_px` is the Cramer-Rao bound of the centre of a disc of diameter d, contrast C and edge s under the noise of a
pixel alone, sqrt(4 s / (sqrt(pi) d)) sigma / C, and `law_px` what `palpate.calibration.noise.noise_by_diameter` says.
"""

import csv
import sys
from itertools import product
from pathlib import Path

import numpy as np

from palpate.calibration import Deviation
from palpate.calibration.noise import noise_by_diameter
from palpate.camera import CameraSpec, project_markers, render
from palpate.core import FloatArray, PalpateError, generator
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.simulation import DEGRADED, SimulatedUnit
from palpate.vision import DetectSpec, prepare_detector

DIAMETERS_MM, DISTANCES_MM = (0.8, 1.0, 1.3, 1.6, 2.0, 2.5), (30.0, 38.0, 48.0, 54.0)
MOVED_MM = 0.3
"""Greatest shift of the camera, about a pixel."""
NEAR_PX = 1.5
"""Distance within which a blob is that of a dot."""
SEEDS = (0, 1, 2)
"""Seeds of light and dirt."""
COLUMNS = ("dot_mm", "distance_mm", "diameter_px", "noise_px", "bound_px", "constant_px", "both_px", "law_px")


def measure(diameter: float, distance: float, seed: int, images: int) -> list[FloatArray]:
    """Noise, average error (two coordinates), diameter and bound of every dot that is found in most images, px."""
    skin = build_skin(DomeSpec())
    layout = place_markers(skin, MarkerSpec(count=37, diameter=diameter))
    rng, errors, detector = generator(seed, "dot noise"), [], None
    for number in range(images):
        x, y = rng.uniform(-MOVED_MM, MOVED_MM, 2)
        scene = SimulatedUnit(
            Design.of_skin(skin, layout, CameraSpec(distance=distance)), Deviation(offset_x=x, offset_y=y), DEGRADED
        )
        look = DEGRADED.model_copy(update={"seed": seed, "noise_seed": number})
        image = render(scene.camera, scene.edges, look)
        camera, dots = scene.camera, scene.edges[:-1]
        truth, diameters = project_markers(camera, dots)
        if detector is None:
            spec = DetectSpec(diameter_px=float(np.median(diameters)), polarity="dark")
            detector, contrast = prepare_detector(image, spec), np.full(len(layout), np.nan)
        blobs = detector.find(image)
        off = np.linalg.norm(truth[:, None] - blobs.positions_px[None], axis=-1)
        near = off.argmin(axis=1)
        there = (off.min(axis=1) < NEAR_PX) & ~blobs.at_border[near]
        errors.append(np.where(there[:, None], blobs.positions_px[near] - truth, np.nan))
        contrast = np.where(there, blobs.contrast[near], contrast)
    off = np.array(errors)
    kept = np.isfinite(off[..., 0]).mean(axis=0) > 0.9
    off = off[:, kept]
    mean = np.nanmedian(off, axis=0)
    noise = 1.4826 * np.nanmedian(np.abs(off - mean), axis=(0, 2))
    diameters, edge = diameters[kept], np.hypot(DEGRADED.blur_px, np.sqrt(1.0 / 12.0))
    bound = np.sqrt(4.0 * edge / (np.sqrt(np.pi) * diameters)) * DEGRADED.noise / contrast[kept]
    return [noise, mean, diameters, bound]


def main(images: str = "30", out: str = "") -> None:
    """Print, and write, one row for every diameter and distance; then the law that fits them best."""
    rows = []
    for diameter, distance in product(DIAMETERS_MM, DISTANCES_MM):
        found = []
        for seed in SEEDS:
            try:
                found.append(measure(diameter, distance, seed, int(images)))
            except PalpateError as error:
                print(f"{diameter} mm at {distance:g} mm: {error.problem}")
        if not found:
            continue
        noise, mean, px, bound = (np.concatenate(parts) for parts in zip(*found, strict=True))
        own, constant = np.sqrt(np.mean(noise**2)), 1.4826 * np.median(np.abs(mean))
        law = np.median(noise_by_diameter(px))
        numbers = (np.median(px), own, np.median(bound), constant, np.hypot(own, constant), law)
        rows.append((diameter, distance, *(round(float(number), 4) for number in numbers)))
        print(*rows[-1], flush=True)
    size, both = np.array(rows)[:, 2], np.array(rows)[:, 6]
    terms, *_ = np.linalg.lstsq(np.column_stack([1.0 / size, size**2]) / both[:, None] ** 2, np.ones(len(size)))
    print(f"both_px² = {terms[0]:.3g} / d + {terms[1]:.3g} d²")
    if out:
        with Path(out).open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])


if __name__ == "__main__":
    main(*sys.argv[1:])
