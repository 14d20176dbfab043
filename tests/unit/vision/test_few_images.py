"""Few images of a motion with many modes: learned motions must not reject what a smooth field assigns."""

import numpy as np

from drawn_tactip import DrawnSensor, place_heads
from palpate.core.run import Progress
from palpate.vision import assign_images


def test_images_are_accepted_although_there_are_too_few_for_all_motions() -> None:
    rng = np.random.default_rng(3)
    rest = place_heads(DrawnSensor(rings=8), np.zeros(6), np.zeros((4, 2)))[0]
    spread, count = 45.0, 60
    blobs, truth = [], []
    for _ in range(count):
        away = rest - rest.mean(axis=0) - rng.uniform(-110, 110, 2)
        push = 1.1 * away * np.exp(-(away**2).sum(axis=1, keepdims=True) / (2 * spread**2)) * rng.uniform(0.3, 1.0)
        truth.append(push)
        blobs.append(rng.permutation(rest + push + rng.normal(0, 0.1, rest.shape)))
    found = assign_images([*blobs, rest], count, (420, 420), True, Progress())
    assert found.good.sum() >= count
    order = [int(np.argmin(np.linalg.norm(rest - place, axis=1))) for place in found.layout.rest_px]
    off = np.linalg.norm(found.moved_px[:count] - np.array(truth)[:, order], axis=2)
    assert np.quantile(off[found.found[:count]], 0.999) < 1.0
