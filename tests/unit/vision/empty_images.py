"""Images without a single dot, drawn by rules of light and cloth: none of them knows how dots are looked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

KINDS = ("gradient", "vignette", "corners", "glints", "rim", "texture", "scratches", "noise", "cloth", "room")


def draw_empty(kind: str, seed: int) -> NDArray[np.uint8]:
    """An image (h, w) of a kind, without dots; size, light, noise and blur by chance."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    width, height = ((346, 260), (640, 480), (320, 240), (480, 480))[rng.integers(4)]
    y, x = np.mgrid[:height, :width] / height
    middle = np.array([width / height / 2, 0.5]) + rng.normal(0, 0.05, 2)
    radius = np.hypot(x - middle[0], y - middle[1])
    grey = rng.uniform(60, 190) + rng.uniform(-80, 80) * (x * np.cos(seed) + y * np.sin(seed) - 0.5)
    grey = _PAINT[kind](grey, x, y, radius, rng)
    grey = _smooth(grey, rng.uniform(0, 1.2))
    grey = grey + rng.choice([0.0, 1.0, 3.0, 8.0]) * rng.normal(size=grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def _smooth(grey: NDArray[np.float64], sigma: float) -> NDArray[np.float64]:
    """Gaussian blur by the Fourier transform of the image and its mirror."""
    if sigma < 0.1:
        return grey
    both = np.block([[grey, grey[:, ::-1]], [grey[::-1], grey[::-1, ::-1]]])
    fy, fx = np.fft.fftfreq(both.shape[0])[:, None], np.fft.rfftfreq(both.shape[1])
    blurred = np.fft.irfft2(np.fft.rfft2(both) * np.exp(-2 * (np.pi * sigma) ** 2 * (fx**2 + fy**2)), both.shape)
    return blurred[: grey.shape[0], : grey.shape[1]]


def _gradient(grey, x, y, radius, rng):
    return grey + rng.uniform(-60, 60) * x**2 + rng.uniform(-60, 60) * np.sin(rng.uniform(0.5, 3) * y + 1)


def _vignette(grey, x, y, radius, rng):
    return grey * (1 - rng.uniform(0.3, 1.0) * (radius / radius.max()) ** rng.uniform(2, 5))


def _corners(grey, x, y, radius, rng):
    edge = rng.uniform(0.75, 0.98) * radius.max()
    return np.where(radius > edge, rng.uniform(0, 30), grey) + 20 * np.exp(-((radius - edge) ** 2) / 1e-4)


def _glints(grey, x, y, radius, rng):
    for _ in range(rng.integers(2, 12)):
        at, long, wide = rng.uniform([0, 0], [x.max(), 1]), rng.uniform(0.01, 0.15), rng.uniform(0.005, 0.05)
        turn = rng.uniform(0, np.pi)
        u = (x - at[0]) * np.cos(turn) + (y - at[1]) * np.sin(turn)
        v = -(x - at[0]) * np.sin(turn) + (y - at[1]) * np.cos(turn)
        grey = grey + rng.uniform(30, 200) * np.exp(-((u / long) ** 2) - (v / wide) ** 2)
    return grey


def _rim(grey, x, y, radius, rng):
    ring, width = rng.uniform(0.3, 0.48), rng.uniform(0.004, 0.03)
    around = np.arctan2(y - y.mean(), x - x.mean())
    lamps = 0.6 + 0.4 * np.cos(rng.integers(1, 9) * around + rng.uniform(0, 6))
    grey = np.where(radius < ring, grey, rng.uniform(10, 60))
    return grey + rng.uniform(60, 200) * lamps * np.exp(-(((radius - ring) / width) ** 2))


def _texture(grey, x, y, radius, rng):
    coarse = _smooth(rng.normal(size=grey.shape), rng.uniform(1.0, 8.0))
    return grey + rng.uniform(5, 40) * coarse / coarse.std()


def _scratches(grey, x, y, radius, rng):
    for _ in range(rng.integers(5, 60)):
        at, turn, long = rng.uniform([0, 0], [x.max(), 1]), rng.uniform(0, np.pi), rng.uniform(0.02, 0.4)
        u = (x - at[0]) * np.cos(turn) + (y - at[1]) * np.sin(turn)
        v = -(x - at[0]) * np.sin(turn) + (y - at[1]) * np.cos(turn) + rng.uniform(-1, 1) * u**2
        grey = grey + rng.uniform(-80, 80) * (np.abs(u) < long) * np.exp(-((v / rng.uniform(0.001, 0.004)) ** 2))
    return grey


def _noise(grey, x, y, radius, rng):
    return grey + rng.uniform(2, 30) * rng.normal(size=grey.shape) * (rng.random(grey.shape) < rng.uniform(0.01, 1))


def _cloth(grey, x, y, radius, rng):
    period, turn = rng.uniform(0.01, 0.06), rng.uniform(0, np.pi)
    u, v = x * np.cos(turn) + y * np.sin(turn), -x * np.sin(turn) + y * np.cos(turn)
    wave = np.sin(2 * np.pi * u / period + 0.5 * np.sin(9 * v))
    return grey + rng.uniform(5, 50) * wave


def _room(grey, x, y, radius, rng):
    for _ in range(rng.integers(4, 20)):
        left, top = rng.uniform([0, 0], [x.max(), 1])
        right, bottom = left + rng.uniform(0.03, 0.5), top + rng.uniform(0.03, 0.5)
        grey = np.where((x > left) & (x < right) & (y > top) & (y < bottom), rng.uniform(0, 255), grey)
    return _glints(grey, x, y, radius, rng)


_PAINT = {
    "gradient": _gradient,
    "vignette": _vignette,
    "corners": _corners,
    "glints": _glints,
    "rim": _rim,
    "texture": _texture,
    "scratches": _scratches,
    "noise": _noise,
    "cloth": _cloth,
    "room": _room,
}
