"""Milliseconds from an image to the pose, its covariance and the force, and of the fit alone.

    python benchmarks/reading_latency.py H20_T2.h5

Three walls press the dome of a twin down and up again, with friction; the images are rendered, degraded, and read one
by one, as a camera gives them, in several passes by sensors that begin anew. Run it on a machine that does nothing
else.
"""

import argparse
import gc
import time
from pathlib import Path

import numpy as np

from palpate.design import Design, MarkerSpec, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import mesh_skin
from palpate.sensor import Unit, open_sensor
from palpate.simulation import SimulatedSource
from palpate.surrogate import read_twin

WALLS = ((3.0, 20.0, 0.8), (6.0, 140.0, 0.5), (9.0, 260.0, 1.2))
"""Tilt and azimuth (degrees) and friction of the three presses."""
AT_REST = 3


def take_images(unit, material):
    mesh = mesh_skin(unit.design.skin)
    presses = [
        solve_press(
            mesh, material, WallSpec(tilt_deg=tilt, azimuth_deg=azimuth, contact=friction, depth=8.0, depth_step=0.8)
        )
        for tilt, azimuth, friction in WALLS
    ]
    return list(SimulatedSource(unit, presses).images())


def time_reading(unit, twin, images):
    """Milliseconds (n, 4) by the clock and of the processor, of the whole and of its fits; share without pose."""
    sensor = open_sensor(images[:AT_REST], unit, twin)
    fits = [0.0, 0.0]
    fit = sensor.estimator.estimate

    def timed(*given, **named):
        clock, busy = time.perf_counter(), time.thread_time()
        found = fit(*given, **named)
        fits[0] += time.perf_counter() - clock
        fits[1] += time.thread_time() - busy
        return found

    object.__setattr__(sensor.estimator, "estimate", timed)
    rows, without = [], 0
    for image in images[AT_REST:]:
        fits[:] = 0.0, 0.0
        clock, busy = time.perf_counter(), time.thread_time()
        reading = sensor.read(image)
        rows.append((time.perf_counter() - clock, time.thread_time() - busy, *fits))
        without += bool(reading.reason)
    return 1e3 * np.array(rows), without / len(rows)


def main():
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("twin", type=Path)
    reader.add_argument("--material", default="zaid_2024_ecoflex_00_30")
    reader.add_argument("--passes", type=int, default=5)
    given = reader.parse_args()
    twin = read_twin(given.twin)
    unit = Unit(Design.of_skin(twin.skin, place_markers(twin.skin, MarkerSpec(count=169))))
    images = take_images(unit, get_material(given.material))
    time_reading(unit, twin, images[:30])  # to compile
    gc.collect()
    passes, without = zip(*(time_reading(unit, twin, images) for _ in range(given.passes)), strict=True)
    took = np.array(passes)
    print(f"{took.shape[1]} images, {given.passes} passes, without a pose: {max(without):.1%}")
    for name, each in (("every reading", took.reshape(-1, 4)), ("least of the passes", took.min(axis=0))):
        for column, part in enumerate(("whole, clock", "whole, CPU", "fit, clock", "fit, CPU")):
            half, most, worst = np.quantile(each[:, column], (0.5, 0.99, 1.0))
            print(f"{name}: {part}: P50 {half:.2f}, P99 {most:.2f}, most {worst:.2f} ms")


if __name__ == "__main__":
    main()
