"""Poses of the obstacle: evenly over the disc of tilts or offsets, or as the paper printed them."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, PalpateError, generator
from palpate.datasets.spec import DatasetSpec
from palpate.design import PoseDensity, rotation_vector

PLASTIC_NUMBER = 1.3247179572447460
"""Real root of x³ = x + 1; its powers give the evenest two-dimensional Kronecker sequence known
(Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018)."""

PAPER_TILTS_DEG = np.arange(0.0, 12.1, 2.0)
PAPER_AZIMUTHS_DEG = {"paper-91": np.arange(0.0, 60.1, 5.0), "paper-504": np.arange(0.0, 359.9, 5.0)}


def sample_poses(
    spec: DatasetSpec, offset: float | None = None, *, lies: bool = False, min_tilt_deg: float = 0.0
) -> FloatArray:
    """First two components of the pose in each virtual press.

    Parameters
    ----------
    spec
        Protocol, number of presses and seed.
    offset
        Maximum offset of an obstacle that does not tilt, mm, or maximum tilt of one that comes to the side,
        degrees; `None` for a wall.
    lies
        Whether it is a line, whose offsets are spread evenly by length, and its directions by angle.
    min_tilt_deg
        Minimum tilt of one that comes to the side, degrees: poses fill the ring between both.

    Returns
    -------
    FloatArray
        (n, 2): rx and ry in degrees, or x and y in mm. The paper's protocols repeat the straight press once an
        azimuth.

    Raises
    ------
    PalpateError
        If a protocol of the paper, which is of tilts, is asked for an obstacle that does not tilt.

    Examples
    --------
    >>> poses = sample_poses(DatasetSpec(n_presses=100))
    >>> poses.shape, bool(np.hypot(*poses.T).max() <= 12.0)
    ((100, 2), True)
    """
    if spec.poses == "disc":
        most = spec.max_tilt_deg if offset is None else offset
        density = PoseDensity.UNIFORM_TILT if lies else PoseDensity.UNIFORM_DISC
        steps = np.array([1.0 / PLASTIC_NUMBER, 1.0 / PLASTIC_NUMBER**2])
        square = (generator(spec.seed, "poses").random(2) + np.arange(spec.n_presses)[:, None] * steps) % 1.0
        return rotation_vector(density.radius(square[:, 0], most, min_tilt_deg), np.deg2rad(360.0 * square[:, 1]))
    if offset is not None:
        raise PalpateError(
            f"The protocol {spec.poses} is one of tilts up to 12°.",
            "Choose the poses 'disc'.",
            code="protocol-not-for-obstacle",
        )
    tilt, azimuth = np.meshgrid(PAPER_TILTS_DEG, PAPER_AZIMUTHS_DEG[spec.poses], indexing="ij")
    return rotation_vector(tilt.ravel(), np.deg2rad(azimuth.ravel()))
