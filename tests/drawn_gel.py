"""Harder drawn recordings of a dome with pins, by other rules than `drawn_tactip`: nothing here is smooth.

A plane comes down on a dome of radius 20 mm and flattens what it meets; at its edge the skin has a kink. The touched
part is dragged by a hidden shear and turned by a hidden yaw, slips in its outer third, and the rest follows the less
the farther it is from the edge. Pins are levers along the inner normal: at the kink their heads run into each
other, cross and fuse. A head is a small disc that is seen from the side as an ellipse, the dimmer the more it is
turned away, so that a threshold loses some. Light leans another way in each image; there are specks, and the sensor's
rim shows as arcs.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from drawn_tactip import NAMES, SIZE, DrawnTruth

RADIUS = 20.0
HEIGHT = 30.0
FOCAL = 545.0
CENTRE = np.array([208.0, 213.0])
RIM = 204.0


@dataclass(frozen=True)
class DrawnGel:
    """One built sensor: rings of its hexagon, length of its pins and radius of their heads, mm, and its dirt."""

    rings: int = 10
    lever: float = 1.5
    head: float = 0.42
    follow: float = 5.0
    dirt: float = 1.0
    seed: int = 0

    def angles(self) -> np.ndarray:
        """(m, 2) polar angle of each pin times its direction, rad."""
        n = self.rings
        cells = [(a, b) for a in range(-n, n + 1) for b in range(-n, n + 1) if abs(a + b) <= n]
        flat = np.array([[a + b / 2, b * np.sqrt(3) / 2] for a, b in cells]) * (1.05 / n)
        turn = np.radians(5.0)
        flat = flat @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        return flat + np.random.default_rng(self.seed).normal(0, 0.003, flat.shape)


def _press(sensor: DrawnGel, angles: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Pressed skin (m, 3), mm, at angles (m, 2)."""
    polar = np.linalg.norm(angles, axis=1)
    out = np.c_[angles * np.sinc(polar / np.pi)[:, None], np.cos(polar)]
    skin, depth = RADIUS * out, motion[2]
    if depth <= 0:
        return skin
    rx, ry = np.radians(motion[:2])
    normal = np.array([np.sin(ry) * np.cos(rx), -np.sin(rx), np.cos(rx) * np.cos(ry)])
    first = np.cross([0.0, 1.0, 0.0], normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    edge = np.arccos((RADIUS - depth) / RADIUS)
    away = np.arccos(np.clip(out @ normal, -1, 1))
    inner = np.clip((1.0 - away / edge) / 0.35, 0, 1) * 0.25 + 0.75
    held = np.clip((1.25 - polar) / 0.5, 0, 1)
    hold = np.where(away < edge, inner, 0.75 * np.exp(-RADIUS * (away - edge) / sensor.follow)) * held
    flat = np.c_[skin @ first, skin @ second]
    yaw = np.radians(motion[5])
    drag = motion[3:5] + yaw * np.c_[-flat[:, 1], flat[:, 0]]
    skin = skin - np.maximum(skin @ normal - (RADIUS - depth), 0)[:, None] * normal
    skin = skin + 0.7 * min(depth / 1.5, 1.0) * hold[:, None] * (drag[:, :1] * first + drag[:, 1:] * second)
    bulge = 0.02 * depth**1.5 * np.where(away > edge, 1 - np.exp(-RADIUS * (away - edge) / 3.0), 0) * held
    return skin + bulge[:, None] * out


def place_pins(sensor: DrawnGel, motion: np.ndarray, waves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heads in the image (m, 2), px, and (m, 4) their half axes, px, direction, rad, and brightness."""
    angles, step = sensor.angles(), 0.01
    skin, right, up = (_press(sensor, angles + d, motion) for d in ([0, 0], [step, 0], [0, step]))
    inward = -np.cross(right - skin, up - skin)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    heads = skin + sensor.lever * inward
    heads[:, :2] += np.sin(3 * angles) @ waves[:2] + np.cos(3 * angles) @ waves[2:]
    away = heads[:, 2] + HEIGHT
    sight = heads + np.array([0.0, 0.0, HEIGHT])
    facing = np.abs((sight * inward).sum(1)) / np.linalg.norm(sight, axis=1)
    size = FOCAL * sensor.head / away * (10 / sensor.rings) ** 0.5
    look = np.c_[size, size * np.maximum(facing, 0.35), np.arctan2(inward[:, 1], inward[:, 0]), facing]
    return CENTRE + FOCAL * heads[:, :2] / away[:, None], look


def draw_gel(places: np.ndarray, look: np.ndarray, rng: np.random.Generator, dirt: float = 1.0) -> np.ndarray:
    """Thresholded image (h, w), 8 bit."""
    canvas = np.zeros((2 * SIZE, 2 * SIZE), np.uint8)
    for k in np.argsort(look[:, 3]):
        (u, v), (size, thin, way, facing) = places[k], look[k]
        middle, axes = (round((2 * u + 0.5) * 16), round((2 * v + 0.5) * 16)), (round(32 * thin), round(32 * size))
        cv2.ellipse(canvas, middle, axes, np.degrees(way), 0, 360, int(255 * facing**1.3), -1, cv2.LINE_AA, 4)
    if dirt:
        middle = tuple(int(x) for x in np.rint(2 * (CENTRE + rng.normal(0, 1.0, 2))))
        for start in (20, 110, 230, 300):
            stop = start + rng.integers(15, 70)
            cv2.ellipse(canvas, middle, (int(2 * RIM),) * 2, 0, start, stop, 130, int(rng.integers(2, 7)))
    grey = cv2.GaussianBlur(cv2.resize(canvas, (SIZE, SIZE), interpolation=cv2.INTER_AREA), (0, 0), 1.1).astype(float)
    rows, columns = np.mgrid[:SIZE, :SIZE] / SIZE - 0.5
    lean = rng.normal(0, 0.22 * dirt, 2)
    grey = 25 + grey * np.clip(0.62 - 0.7 * (rows**2 + columns**2) + lean[0] * rows + lean[1] * columns, 0.12, 1)
    grey = grey + rng.normal(0, 6.0, grey.shape)
    bright = np.where(grey > cv2.blur(grey, (35, 35)) + 26, 255, 0).astype(np.uint8)
    for _ in range(rng.poisson(6 * dirt)):
        place = tuple(int(x) for x in rng.integers(30, SIZE - 30, 2))
        cv2.circle(bright, place, int(rng.integers(0, 4)), int(rng.choice([0, 255], p=[0.35, 0.65])), -1)
    cv2.circle(shade := np.zeros_like(bright), tuple(int(x) for x in CENTRE), int(RIM) + 4, 1, -1)
    return bright * shade


def draw_gel_recording(
    folder: Path,
    motions: np.ndarray,
    sensor: DrawnGel = DrawnGel(),
    *,
    seed: int = 0,
    rest: bool = False,
    told: tuple[str, ...] = NAMES[:3],
) -> DrawnTruth:
    """Draw images in no order, and `poses.csv` of them, into a folder; see `drawn_tactip.draw_recording`."""
    (folder / "images").mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, 5])
    still, look = place_pins(sensor, np.zeros(6), np.zeros((4, 2)))
    if rest:
        cv2.imwrite(str(folder / "images" / "rest.png"), draw_gel(still, look, rng, sensor.dirt))
    unit = {"depth": "mm", "shear_x": "mm", "shear_y": "mm"}
    columns = [NAMES.index(name) for name in told]
    rows, heads, seen = [["image", *(f"{name}_{unit.get(name, 'deg')}" for name in told)]], [], []
    for number, motion in enumerate(motions):
        places, look = place_pins(sensor, motion, rng.normal(0, 0.02, (4, 2)))
        name = f"image_{number:05d}.png"
        cv2.imwrite(str(folder / "images" / name), draw_gel(places, look, rng, sensor.dirt))
        apart = np.linalg.norm(places[:, None] - places[None], axis=-1) + 1e9 * np.eye(len(places))
        inside = np.linalg.norm(places - CENTRE, axis=1) + look[:, 0] < RIM - 4
        seen.append(inside & (apart.min(1) > 2 * look[:, 0] + 1.0) & (look[:, 3] > 0.5))
        heads.append(places)
        noise = np.where([unit.get(NAMES[c]) == "mm" for c in columns], 0.01, 0.03)
        rows.append([name, *(f"{x:.4f}" for x in motion[columns] + rng.normal(0, 1, len(columns)) * noise)])
    with (folder / "poses.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return DrawnTruth(motions, np.array(heads), np.array(seen), still)
