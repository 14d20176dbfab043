"""Images per CPU-second of a twin: single, in batch on torch, and in MuJoCo (example 14); per second on a GPU.

python benchmarks/simulated_images.py TWIN.h5
python benchmarks/simulated_images.py TWIN.h5 cuda    images with forces; poses and results stay on the device
"""

import runpy
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from palpate.camera import Camera, build_camera
from palpate.core import FloatArray
from palpate.design import MarkerSpec, place_markers
from palpate.surrogate import BatchTwin, MarkerTwin, Twin, read_twin

COUNT, ONE_BY_ONE = 20_000, 2_000
ON_GPU, BATCH, ROUNDS = 1 << 21, 1 << 17, 5
EXAMPLE = Path(__file__).parents[1] / "examples" / "ex14_mujoco.py"


def rate(does: Callable[[], object], images: int) -> float:
    """Images a CPU-second, the best of three runs after one that compiles."""
    does()
    took = []
    for _ in range(3):
        start = time.process_time()
        does()
        took.append(time.process_time() - start)
    return images / min(took)


def sample(twin: Twin, count: int) -> tuple[FloatArray, FloatArray]:
    """Sample poses (n, 3) and 1/µ (n,) over the range of a twin."""
    rng = np.random.default_rng(0)
    tilt, deep = float(twin.tilts_deg[-1]) / np.sqrt(2.0), float(twin.depths_mm[-1])
    poses = np.column_stack([rng.uniform(-tilt, tilt, (count, 2)), rng.uniform(0.0, deep, count)])
    return poses, rng.uniform(0.0, float(twin.inverse_frictions[-1]), count)


def time_gpu(twin: Twin, camera: Camera, markers: MarkerTwin) -> None:
    """Print images with forces per second, and the difference from double precision on the processor."""
    poses, frictions = sample(twin, ON_GPU)
    expected = BatchTwin(markers, camera).evaluate(poses[:4096], frictions[:4096])
    for dtype in ("float64", "float32"):
        batch = BatchTwin(markers, camera, device="cuda", dtype=dtype)
        given = [torch.as_tensor(each, device="cuda", dtype=getattr(torch, dtype)) for each in (poses, frictions)]
        found = batch.evaluate(*(each[:4096] for each in given))
        px, newtons = (float((a.double().cpu() - b).abs().max()) for a, b in zip(found, expected, strict=True))
        times = []
        for _ in range(ROUNDS):
            torch.cuda.synchronize()
            start = time.perf_counter()
            for piece in zip(*(each.split(BATCH) for each in given), strict=True):
                batch.evaluate(*piece)
            torch.cuda.synchronize()
            times.append(time.perf_counter() - start)
        print(f"cuda, {dtype}: {ON_GPU / min(times) / 1e6:.2f} million/s, {px:.1e} px and {newtons:.1e} N apart")


def main(path: Path, device: str = "cpu") -> None:
    torch.set_num_threads(1)
    twin, camera = read_twin(path), build_camera()
    dots = twin.with_markers(place_markers(twin.skin, MarkerSpec(count=169)).positions)
    if device == "cuda":
        time_gpu(twin, camera, dots)
        return
    poses, slips = sample(twin, COUNT)
    few = list(zip(poses[:ONE_BY_ONE], slips[:ONE_BY_ONE], strict=True))
    exact = np.array([camera.project(dots.evaluate(*each).positions) for each in few])
    print(
        f"one by one: "
        f"{rate(lambda: [camera.project(dots.evaluate(*each).positions) for each in few], len(few)):.0f}/s"
    )
    for dtype in ("float64", "float32"):
        batch = BatchTwin(dots, camera, dtype=dtype)
        apart = np.abs(batch.pixels(poses[:ONE_BY_ONE], slips[:ONE_BY_ONE]).numpy() - exact).max()
        each = rate(lambda batch=batch: batch.pixels(poses, slips), COUNT)
        print(f"in batch, {dtype}: {each:.0f}/s, at most {apart:.1e} px apart")
    example = runpy.run_path(str(EXAMPLE))
    model = example["load"](example["press"](0.0))
    print(f"in MuJoCo: {rate(lambda: example['run'](model, twin), example['STEPS']):.0f}/s")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
