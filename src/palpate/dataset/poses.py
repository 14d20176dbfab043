"""Poses of the wall: evenly over the disc of tilts, or as the paper printed them."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, generator
from palpate.dataset.spec import DatasetSpec

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
    return rotation_components(tilt.ravel(), azimuth.ravel())


def rotation_components(tilt_deg: FloatArray, azimuth_deg: FloatArray) -> FloatArray:
    """Components (rx, ry) = tilt · (cos azimuth, sin azimuth) of the wall's rotation, (n, 2) degrees."""
    azimuth = np.deg2rad(azimuth_deg)
    return np.stack([tilt_deg * np.cos(azimuth), tilt_deg * np.sin(azimuth)], axis=-1)


def _disc(n: int, max_tilt_deg: float, seed: int) -> FloatArray:
    """Evenly by area: a Kronecker sequence on the unit square, shifted at random, bent into a disc."""
    start = generator(seed, "poses").random(2)
    steps = np.array([1.0 / PLASTIC_NUMBER, 1.0 / PLASTIC_NUMBER**2])
    square = (start + np.arange(n)[:, None] * steps) % 1.0
    return rotation_components(max_tilt_deg * np.sqrt(square[:, 0]), 360.0 * square[:, 1])
