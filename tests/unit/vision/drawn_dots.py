"""Dots drawn by formula, with known centres: only for tests."""

import numpy as np
from scipy.special import erf, ive


def draw_dots(centres, diameter, edge, contrast, shape, ground=220.0):
    """Dark dots whose level falls as the normal distribution across the edge: the model of the bound below."""
    image = np.full(shape, float(ground))
    half = int(diameter / 2 + 5 * edge + 2)
    for column, row in centres:
        left, top = int(column) - half, int(row) - half
        x = np.arange(max(left, 0), min(left + 2 * half + 2, shape[1]))
        y = np.arange(max(top, 0), min(top + 2 * half + 2, shape[0]))
        radius = np.hypot(x[None] - column, y[:, None] - row)
        level = 0.5 * (1 + erf((diameter / 2 - radius) / (edge * np.sqrt(2))))
        image[y[0] : y[-1] + 1, x[0] : x[-1] + 1] -= contrast * level
    return image


def bound(diameter, edge, contrast, noise):
    """Cramér-Rao bound of a coordinate: sigma ≥ 2 (noise / contrast) √(edge / (√π diameter))."""
    return 2 * noise / contrast * np.sqrt(edge / (np.sqrt(np.pi) * diameter))


def bound_of_blurred_disc(diameter, edge, contrast, noise):
    """The same for a disc blurred in the plane, whose slope is (R/s²) exp(-(r-R)²/2s²) e⁻ᶻ I₁(z), z = rR/s²."""
    radius = diameter / 2
    r = np.linspace(1e-3, radius + 6 * edge, 4000)
    slope = radius / edge**2 * np.exp(-((r - radius) ** 2) / 2 / edge**2) * ive(1, r * radius / edge**2)
    return noise / contrast / np.sqrt(np.pi * np.trapezoid(slope**2 * r, r))


def lattice(count, spacing, rng, jitter=0.5):
    """`count`² centres on a square lattice, each moved by up to `jitter`, and the image's shape."""
    grid = np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1).reshape(-1, 2)
    centres = grid * spacing + spacing / 2 + rng.uniform(-jitter, jitter, (count**2, 2))
    return centres, (int(count * spacing) + 1,) * 2


def with_noise(image, noise, rng, largest=255):
    made = np.clip(np.rint(image + rng.normal(0, noise, image.shape)), 0, largest)
    return made.astype(np.uint8 if largest == 255 else np.uint16)


def match(found, true):
    """Errors (k, 2) of the found centres within 2 px of a true one, number missed and number of extras."""
    distance = np.linalg.norm(found[:, None] - true[None], axis=-1)
    near, which = distance.min(axis=1) < 2.0, distance.argmin(axis=1)
    return (found - true[which])[near], len(true) - len(set(which[near])), int((~near).sum())
