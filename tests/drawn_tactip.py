"""Drawn recordings of a gel-filled dome with pins in a hexagon: rules of their own, nothing of the package's.

A dome of radius 20 mm carries pins on its inner side, whose heads stand `lever` mm inside along the inner normal, so
that a bend of the skin is seen larger. A plane of tilt (rx, ry) comes down by `depth`. Skin that would be beyond it
is pushed onto it, gel bulges beside it, and the touched part is dragged by a hidden shear and turned by a hidden yaw,
which the rest of the skin follows the less the nearer it is to its rim. A pinhole camera from below sees white heads
before black gel through a round window; such labs keep the images thresholded.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np

RADIUS = 20.0
SIZE = 420
WINDOW = 203
"""Radius of the round window that the camera looks through, px: pins at the rim come and go."""
NAMES = ("rx", "ry", "depth", "shear_x", "shear_y", "yaw")


@dataclass(frozen=True)
class DrawnSensor:
    """One built sensor: rings of the hexagon, its camera, its print."""

    rings: int = 10
    lever: float = 1.6
    height: float = 26.0
    reach: float = 17.6
    turn_deg: float = 3.0
    centre: tuple[float, float] = (211.0, 207.0)
    softness: float = 4.0
    misprint: float = 0.04
    pattern: str = "hexagon"
    seed: int = 0

    @cache  # noqa: B019
    def pins(self) -> np.ndarray:
        """(m, 2) places in the plane, mm."""
        rng = np.random.default_rng(self.seed)
        if self.pattern == "hexagon":
            n = self.rings
            cells = [(a, b) for a in range(-n, n + 1) for b in range(-n, n + 1) if abs(a + b) <= n]
            places = np.array([[a + b / 2, b * np.sqrt(3) / 2] for a, b in cells]) * (self.reach / n)
        elif self.pattern == "square":
            n = self.rings
            places = np.array([[a, b] for a in range(-n, n + 1) for b in range(-n, n + 1)]) * (self.reach / n * 0.72)
        elif self.pattern == "rings":
            turns = [np.arange(6 * k) / (6 * k) * 2 * np.pi + 0.3 * k for k in range(1, self.rings + 1)]
            places = np.vstack(
                [
                    [[0.0, 0.0]],
                    *[np.c_[np.cos(t), np.sin(t)] * (k + 1) * self.reach / self.rings for k, t in enumerate(turns)],
                ]
            )
        else:
            places = scatter_evenly(rng, 1 + 3 * self.rings * (self.rings + 1), self.reach)
        return places + rng.normal(0, self.misprint, places.shape)


def scatter_evenly(rng: np.random.Generator, count: int, reach: float) -> np.ndarray:
    least, kept = 1.55 * reach / np.sqrt(count) * 0.85, []
    for _ in range(40_000):
        place = reach * np.sqrt(rng.random()) * np.array([np.cos(a := 2 * np.pi * rng.random()), np.sin(a)])
        if all(np.hypot(*(place - other)) > least for other in kept):
            kept.append(place)
        if len(kept) == count:
            break
    return np.array(kept)


def draw_motions(count: int, seed: int = 0, shear: float = 5.0, tilt: float = 25.0) -> np.ndarray:
    """(n, 6) by `NAMES`: what the robot was sent to, spread evenly; mm and degrees."""
    rng = np.random.default_rng([seed, 1])
    low = np.array([-tilt, -tilt, 1.0, -shear, -shear, -5.0])
    return rng.uniform(low, [tilt, tilt, 6.0, shear, shear, 5.0], (count, 6))


def _skin(sensor: DrawnSensor, flat: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Pressed skin (n, 3) over places (n, 2), mm."""
    rx, ry = np.radians(motion[:2])
    depth, shear, yaw = motion[2], motion[3:5], np.radians(motion[5])
    square = np.minimum((flat**2).sum(1), 0.985 * RADIUS**2)
    skin = np.c_[flat, np.sqrt(RADIUS**2 - square)]
    if depth <= 0:
        return skin
    normal = np.array([np.sin(ry) * np.cos(rx), -np.sin(rx), np.cos(rx) * np.cos(ry)])
    beyond = skin @ normal - (RADIUS - depth)
    s = sensor.softness
    pushed = s * np.logaddexp(0.0, beyond / s)
    touched = 1 / (1 + np.exp(-(beyond + 0.6) / (1.4 * s)))
    place = normal[:2] * (RADIUS - depth / 2)
    apart = flat - place
    spread = 5.0 + 1.6 * np.sqrt(2 * RADIUS * depth)
    follow = np.exp(-((apart**2).sum(1)) / (2 * (0.55 * spread) ** 2))
    rim = np.clip(1.05 - square / (0.98 * RADIUS**2), 0, 1) ** 0.35
    stuck = 1 - np.exp(-depth / 1.2)
    dragged = shear[None] + yaw * np.c_[-apart[:, 1], apart[:, 0]]
    moved = np.zeros_like(skin)
    moved[:, :2] += 0.62 * stuck * (0.35 * touched + 0.65 * follow)[:, None] * dragged * rim[:, None]
    moved -= (pushed * (0.4 + 0.6 * rim))[:, None] * normal
    bulge = 0.05 * depth**1.3 * np.exp(-(((np.hypot(*apart.T) - 0.8 * spread) / 5.0) ** 2)) * rim
    return skin + moved + bulge[:, None] * skin / RADIUS


def place_heads(sensor: DrawnSensor, motion: np.ndarray, waves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Heads in the image (m, 2) and their radius (m,), px; `waves` (4, 2) is what the gel does on its own, mm."""
    flat, step = sensor.pins(), 0.05
    skin, right, up = (_skin(sensor, flat + d, motion) for d in ([0, 0], [step, 0], [0, step]))
    inward = -np.cross(right - skin, up - skin)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    heads = skin + sensor.lever * inward
    way = flat / RADIUS * np.pi
    heads[:, :2] += np.sin(way) @ waves[:2] + np.cos(way) @ waves[2:]
    focal = 218.0 * (sensor.height + 12.0) / RADIUS
    away = heads[:, 2] + sensor.height
    turned = np.radians(sensor.turn_deg)
    plane = heads[:, :2] @ np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    return sensor.centre + focal * plane / away[:, None], focal * 0.36 / away * (10 / sensor.rings) ** 0.5


def draw_image(
    places: np.ndarray, radii: np.ndarray, rng: np.random.Generator, threshold: bool = True, dark: bool = False
) -> np.ndarray:
    """Image (h, w) of heads, 8 bit: uneven light, noise, and then black and white."""
    canvas = np.zeros((2 * SIZE, 2 * SIZE), np.uint8)
    for (u, v), r in zip(places, radii, strict=True):
        cv2.circle(
            canvas, (round((2 * u + 0.5) * 16), round((2 * v + 0.5) * 16)), round(32 * r), 255, -1, cv2.LINE_AA, 4
        )
    grey = cv2.GaussianBlur(cv2.resize(canvas, (SIZE, SIZE), interpolation=cv2.INTER_AREA), (0, 0), 0.8).astype(float)
    rows, columns = np.mgrid[:SIZE, :SIZE] / SIZE - 0.5
    grey = 22 + grey * (0.72 - 0.5 * (rows**2 + columns**2) + 0.1 * columns) + 12 * columns
    grey = grey + rng.normal(0, 5.0, grey.shape)
    if threshold:
        ground = cv2.blur(grey, (31, 31))
        grey = np.where(grey > ground + 28, 255, 0)
    grey = np.clip(grey, 0, 255).astype(np.uint8)
    cv2.circle(shade := np.zeros_like(grey), (SIZE // 2, SIZE // 2), WINDOW, 1, -1)
    grey = grey * shade
    return 255 - grey if dark else grey


@dataclass(frozen=True)
class DrawnTruth:
    """What was drawn: motions (n, 6), heads (n, m, 2) and which of them an image shows by itself (n, m)."""

    motions: np.ndarray
    heads: np.ndarray
    seen: np.ndarray
    rest: np.ndarray


def draw_recording(
    folder: Path,
    motions: np.ndarray,
    sensor: DrawnSensor = DrawnSensor(),
    *,
    seed: int = 0,
    threshold: bool = True,
    dark: bool = False,
    told: tuple[str, ...] = NAMES[:3],
    label_noise: tuple[float, float] = (0.03, 0.01),
    rest: bool = True,
    write: Callable[[Path, np.ndarray], object] = lambda path, image: cv2.imwrite(str(path), image),
) -> DrawnTruth:
    """Draw images and `poses.csv` of them into a folder."""
    (folder / "images").mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, 2])
    still, radii = place_heads(sensor, np.zeros(6), np.zeros((4, 2)))
    unit = {"depth": "mm", "shear_x": "mm", "shear_y": "mm"}
    columns = [NAMES.index(name) for name in told]
    rows, heads, seen = [["image", *(f"{name}_{unit.get(name, 'deg')}" for name in told)]], [], []
    if rest:
        write(folder / "images" / "rest.png", draw_image(still, radii, rng, threshold, dark))
    for number, motion in enumerate(motions):
        places, radii = place_heads(sensor, motion, rng.normal(0, 0.02, (4, 2)))
        name = f"image_{number:05d}.png"
        write(folder / "images" / name, draw_image(places, radii, rng, threshold, dark))
        near = np.linalg.norm(places[:, None] - places[None], axis=-1) + 1e9 * np.eye(len(places))
        inside = np.linalg.norm(places - SIZE // 2, axis=1) + radii < WINDOW
        seen.append(inside & (near.min(1) > 2 * radii + 1.0))
        heads.append(places)
        noise = np.where([unit.get(NAMES[c]) == "mm" for c in columns], label_noise[1], label_noise[0])
        rows.append([name, *(f"{x:.4f}" for x in motion[columns] + rng.normal(0, 1, len(columns)) * noise)])
    with (folder / "poses.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return DrawnTruth(motions, np.array(heads), np.array(seen), still)


def another_unit(sensor: DrawnSensor) -> DrawnSensor:
    """The same make, built again: camera turned and off, gel and lever a little other."""
    return replace(sensor, turn_deg=sensor.turn_deg - 2.0, centre=(207.0, 212.0), softness=4.4, lever=1.7, seed=7)
