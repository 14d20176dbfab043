"""Dots of a dome at rest seen by a camera of unknown pose, and through a made-up press: only for tests."""

import numpy as np

FOCAL, MIDDLE, DISTANCE = 297.5, np.array([174.9, 128.2]), 48.0


def project(points):
    return FOCAL * points[..., :2] / (points[..., 2:] + DISTANCE) + MIDDLE


def turn(angle, axis):
    a, b = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[a, a] = matrix[b, b] = np.cos(angle)
    matrix[b, a], matrix[a, b] = np.sin(angle), -np.sin(angle)
    return matrix


def posed_dots(points, markers, rng, mirror=None, missing=0.1, false=0.05):
    """Dots (n, 2) in random order, the number of the dot of each of the first `markers` points (-1), mirrored."""
    azimuth, tilt = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(0, 5))
    rotation = turn(azimuth, 2) @ turn(tilt, 0) @ turn(-azimuth, 2) @ turn(rng.uniform(0, 2 * np.pi), 2)
    mirror = bool(rng.random() < 0.5) if mirror is None else mirror
    middle = [0.0, 0.0, points[:, 2].max() / 2]
    posed = (points * [1, -1 if mirror else 1, 1] - middle) @ rotation.T + middle
    way, far = rng.uniform(0, 2 * np.pi), 20 * np.sqrt(rng.random())
    pixels = project(posed) + far * np.array([np.cos(way), np.sin(way)]) + rng.normal(0, 0.1, (len(points), 2))
    inside = np.all((pixels > 0) & (pixels < [346, 260]), axis=1)
    seen = np.flatnonzero(inside & (rng.random(len(points)) >= missing))
    extra = rng.uniform(0, 1, (round(false * len(points)), 2)) * [346, 260]
    order = rng.permutation(len(seen) + len(extra))
    place = np.argsort(order)[: len(seen)]
    truth = np.full(len(points), -1)
    truth[seen] = place
    return np.vstack([pixels[seen], extra])[order], truth[:markers], mirror


def pressed(points, depth, tilt=0.15):
    """Points near the apex pushed down and aside, those at the base held."""
    push = depth * np.exp(-(points[:, 2].max() - points[:, 2]) / 6.0) * (points[:, 2] > 0)
    return points + push[:, None] * np.array([tilt, 0.4 * tilt, -1.0])
