"""A made-up dataset whose images are a smooth map of the pose: only for tests."""

import numpy as np

from palpate.datasets import Dataset, DatasetSpec, sample_poses


def make_dataset(presses=120, markers=12, depths=(2.4, 4.0, 5.6), bend=4.0, jitter_px=2.0, seed=0):
    """Images u = rest + A·pose + bend · quadratic; `bend` 0 makes the map linear."""
    rng = np.random.default_rng(99)
    spec = DatasetSpec(n_presses=presses, jitter_px=jitter_px, seed=seed)
    rotations = np.repeat(sample_poses(spec), len(depths), axis=0)
    poses = np.column_stack([rotations, np.tile(depths, presses)])
    scaled = poses / [12.0, 12.0, 8.0]
    rest = rng.uniform(60, 200, (markers, 2))
    linear = rng.normal(0, 12.0, (3, 2 * markers))
    squares = np.stack([scaled[:, i] * scaled[:, j] for i in range(3) for j in range(i, 3)], axis=1)
    moved = scaled @ linear + bend * squares @ rng.normal(0, 1.0, (6, 2 * markers))
    press = np.repeat(np.arange(presses), len(depths))
    return Dataset(
        spec=spec,
        images_px=rest + moved.reshape(len(poses), markers, 2),
        poses=poses,
        press=press,
        validation=press % 5 == 0,
        branch=np.full(len(poses), "flat"),
        travel_mm=np.full(len(poses), 1.0),
        rest_px=rest,
        image_size_px=(346, 260),
        solved_presses=7,
        dropped={},
    )
