"""Poses of the wall: evenly over the disc of tilts, or as the paper printed them."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, generator
from palpate.dataset.spec import DatasetSpec
from palpate.design import rotation_vector

PLASTIC_NUMBER = 1.3247179572447460
"""Real root of x³ = x + 1; its powers give the evenest two-dimensional Kronecker sequence known
(Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018)."""

PAPER_TILTS_DEG = np.arange(0.0, 12.1, 2.0)
PAPER_AZIMUTHS_DEG = {"paper-91": np.arange(0.0, 60.1, 5.0), "paper-504": np.arange(0.0, 359.9, 5.0)}


def sample_poses(spec: DatasetSpec) -> FloatArray:
    """Rotation of the wall in each virtual press.

    Parameters
    ----------
    spec
        Protocol, number of presses and seed.

    Returns
    -------
    FloatArray
        (n, 2): rx and ry in degrees. The paper's protocols repeat the straight press once an azimuth.
    """
    if spec.poses == "disc":
        return _disc(spec.n_presses, spec.max_tilt_deg, spec.seed)
    tilt, azimuth = np.meshgrid(PAPER_TILTS_DEG, PAPER_AZIMUTHS_DEG[spec.poses], indexing="ij")
    return rotation_vector(tilt.ravel(), np.deg2rad(azimuth.ravel()))


def _disc(n: int, max_tilt_deg: float, seed: int) -> FloatArray:
    """Evenly by area: a Kronecker sequence on the unit square, shifted at random, bent into a disc."""
    start = generator(seed, "poses").random(2)
    steps = np.array([1.0 / PLASTIC_NUMBER, 1.0 / PLASTIC_NUMBER**2])
    square = (start + np.arange(n)[:, None] * steps) % 1.0
    return rotation_vector(max_tilt_deg * np.sqrt(square[:, 0]), np.deg2rad(360.0 * square[:, 1]))
