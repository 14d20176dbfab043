"""A rim with screws, broken arcs and glints about drawn pins, 331 in a hexagon or rings: what passes for markers."""

import cv2
import numpy as np
import pytest

from drawn_tactip import SIZE, WINDOW, DrawnSensor, draw_image, draw_motions, place_heads
from palpate.vision import prepare_detector
from palpate.vision.stray_blobs import find_strays


def draw_rim(image: np.ndarray, rng: np.random.Generator) -> None:
    c = SIZE // 2
    for _ in range(5):
        start, grey, width = rng.uniform(0, 360), int(rng.integers(150, 255)), int(rng.integers(1, 5))
        cv2.ellipse(image, (c, c), (204, 204), 0, start, start + rng.uniform(2, 50), grey, width, cv2.LINE_AA)
    for count, low, high, least, most in ((4, 207, 208, 3, 7), (8, 195, 208, 1, 4)):  # screws, glints
        for _ in range(count):
            angle, away = rng.uniform(0, 2 * np.pi), rng.uniform(low, high)
            middle = int(c + away * np.cos(angle)), int(c + away * np.sin(angle))
            cv2.circle(image, middle, int(rng.integers(least, most)), int(rng.integers(120, 255)), -1, cv2.LINE_AA)


def place_grid(count: int) -> np.ndarray:
    return 20.0 * np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1).reshape(-1, 2).astype(float)


def place_on_rings(count: int, step: float) -> np.ndarray:
    turns = [2 * np.pi * np.arange(6 * k) / (6 * k) + 0.3 * k for k in range(1, count + 1)]
    return np.vstack([[[0.0, 0.0]], *[step * (k + 1) * np.c_[np.cos(t), np.sin(t)] for k, t in enumerate(turns)]])


def place_rings(rng: np.random.Generator, pressed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Pins of a TacTip in ten rings 18.3 px apart; pressed, all move outward and aside by up to some 15 px."""
    heads = place_on_rings(10, 18.27) + rng.normal(0.0, 0.2, (331, 2)) + [211.2, 212.2]
    if pressed:
        away = heads - SIZE / 2
        radius = np.hypot(*away.T)[:, None]
        heads += away / radius * 10.0 * np.sin(np.pi * radius / SIZE) + [7.0, 5.0] * np.exp(-((radius / 120.0) ** 2))
    return heads, np.full(331, 5.0) + rng.normal(0.0, 0.2, 331)


@pytest.mark.parametrize(("rims", "most"), [(1, 1.0), (3, 4.0)])  # some 12 and 36 things
@pytest.mark.parametrize("pattern", ["hexagon", "rings"])
def test_few_things_of_a_rim_pass_for_markers_and_none_is_lost(pattern: str, rims: int, most: float) -> None:
    extra, lost = [], 0
    for seed in range(12):
        rng = np.random.default_rng([seed, 5])
        if pattern == "rings":
            heads, radii = place_rings(rng, seed % 3 > 0)
        else:
            motion = draw_motions(1, seed)[0] if seed % 3 else np.zeros(6)
            heads, radii = place_heads(DrawnSensor(seed=seed), motion, np.zeros((4, 2)))
        image = draw_image(heads, radii, rng, threshold=seed % 2 > 0)
        for _ in range(rims):
            draw_rim(image, rng)
        found = prepare_detector(image).find(image).positions_px
        away = np.linalg.norm(heads[:, None] - found, axis=-1)
        inside = np.hypot(*(heads - SIZE // 2).T) + radii < WINDOW - 14  # no glint covers these
        lost += int((away.min(axis=1)[inside] > 3.0).sum())
        extra.append(int((away.min(axis=0) > 3.5).sum()))
    assert lost <= 1  # of some 3 800: a corner of the hexagon that stands out under a deep press
    assert np.mean(extra) <= most, extra


@pytest.mark.parametrize("points", [place_grid(12), place_on_rings(5, 20.0), place_on_rings(10, 20.0)])
def test_a_field_alone_loses_no_marker_and_keeps_an_orientation_mark(points: np.ndarray) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        pushed = points + rng.normal(0.0, 0.4, points.shape)
        away = pushed - pushed.mean(axis=0) - rng.normal(0.0, 40.0, 2)
        pushed += 0.1 * away * np.exp(-((away / 80.0) ** 2).sum(axis=1))[:, None]
        x, y = pushed.mean(axis=0)
        marked = np.vstack([pushed, [x + np.ptp(pushed[:, 0]) / 2 + 19.0, y + 3.0]])
        assert not find_strays(pushed, np.full(len(pushed), 8.0)).any()
        assert not find_strays(marked, np.full(len(marked), 8.0)).any()
