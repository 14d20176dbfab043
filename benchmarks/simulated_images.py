"""Images a second of CPU time: the twin of a design one by one, in batch on torch, and in MuJoCo (example 14).

python benchmarks/simulated_images.py TWIN.h5
"""

import runpy
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from palpate.camera import build_camera
from palpate.design import MarkerSpec, place_markers
from palpate.surrogate import BatchTwin, read_twin

COUNT, ONE_BY_ONE = 20_000, 2_000
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


def main(path: Path) -> None:
    torch.set_num_threads(1)
    twin, camera = read_twin(path), build_camera()
    dots = twin.with_markers(place_markers(twin.skin, MarkerSpec(count=169)).positions)
    rng = np.random.default_rng(0)
    tilt, deep = float(twin.tilts_deg[-1]) / np.sqrt(2.0), float(twin.depths_mm[-1])
    poses = np.column_stack([rng.uniform(-tilt, tilt, (COUNT, 2)), rng.uniform(0.0, deep, COUNT)])
    slips = rng.uniform(0.0, float(twin.inverse_frictions[-1]), COUNT)
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
    main(Path(sys.argv[1]))
