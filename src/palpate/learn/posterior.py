"""Mean of the posterior under uniform jitter, by hit-and-run.

With jitter uniform in ±a the likelihood of a pose offset δ is flat inside the polytope

    { δ : |e − J δ| ≤ a in every coordinate }

and zero outside, e being the jitter that was drawn at the true pose δ = 0. The mean of the polytope (cut by the
prior) is the estimate of minimum mean square error. Hit-and-run (Smith 1984) walks through it: pick a direction,
find the chord, go to a point drawn evenly from it. Averaging the middles of the chords, not the points, halves
the noise (Rao–Blackwell).
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, kernel

BURN_IN = 20
"""Steps that let a walk forget that it starts at the true pose. By hand."""


@kernel
def hit_and_run(
    jacobian: FloatArray,
    noise: FloatArray,
    half_width: float,
    directions: FloatArray,
    places: FloatArray,
    disc: FloatArray,
) -> FloatArray:
    """Mean pose offset of one walk for each draw of noise.

    Parameters
    ----------
    jacobian
        (c, d) px per unit of the pose.
    noise
        (w, c) px within ±`half_width`, one row a walk.
    half_width
        Half-width of the uniform jitter (px).
    directions
        (w, s, d) direction of each step, in units of the pose; any length.
    places
        (w, s) 0 … 1, where on its chord each step ends.
    disc
        (3,) rx and ry of the true pose and the radius of the disc of tilts, the prior (degrees); an infinite
        radius for none.

    Returns
    -------
    FloatArray
        (w, d) mean offset.
    """
    walks, steps, dimensions = directions.shape
    coordinates = jacobian.shape[0]
    means = np.zeros((walks, dimensions))
    change = np.empty(coordinates)
    for walk in range(walks):
        rest = noise[walk].copy()  # e − J δ
        offset = np.zeros(dimensions)
        for step in range(steps):
            low, high = -np.inf, np.inf
            for i in range(coordinates):
                slope = 0.0
                for k in range(dimensions):
                    slope += jacobian[i, k] * directions[walk, step, k]
                change[i] = slope
                if slope != 0.0:
                    inverse = 1.0 / slope
                    centre, reach = rest[i] * inverse, abs(half_width * inverse)
                    low, high = max(low, centre - reach), min(high, centre + reach)
            if disc[2] < np.inf:  # |p + t v|² ≤ R²
                vx, vy = directions[walk, step, 0], directions[walk, step, 1]
                px, py = disc[0] + offset[0], disc[1] + offset[1]
                a, b = vx * vx + vy * vy, px * vx + py * vy
                root = np.sqrt(max(b * b - a * (px * px + py * py - disc[2] * disc[2]), 0.0))
                low, high = max(low, (-b - root) / a), min(high, (-b + root) / a)
            middle = 0.5 * (low + high)
            length = low + places[walk, step] * (high - low)
            for k in range(dimensions):
                if step >= BURN_IN:
                    means[walk, k] += offset[k] + middle * directions[walk, step, k]
                offset[k] += length * directions[walk, step, k]
            for i in range(coordinates):
                rest[i] -= length * change[i]
    return means / (steps - BURN_IN)
