"""Poses of the obstacle: evenly over the disc of tilts or offsets, or as the paper printed them."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, PalpateError, generator
from palpate.dataset.spec import DatasetSpec
from palpate.design import rotation_vector

PLASTIC_NUMBER = 1.3247179572447460
"""Real root of x³ = x + 1; its powers give the evenest two-dimensional Kronecker sequence known
(Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018)."""

PAPER_TILTS_DEG = np.arange(0.0, 12.1, 2.0)
PAPER_AZIMUTHS_DEG = {"paper-91": np.arange(0.0, 60.1, 5.0), "paper-504": np.arange(0.0, 359.9, 5.0)}


def sample_poses(
    spec: DatasetSpec, offset: float | None = None, *, lies: bool = False, least: float = 0.0
) -> FloatArray:
    """First two components of the pose in each virtual press.

    Parameters
    ----------
    spec
        Protocol, number of presses and seed.
    offset
        Greatest offset of an obstacle that does not tilt, mm, or greatest tilt of one that comes to the side,
        degrees; `None` for a wall.
    lies
        Whether it is a line, whose offsets are spread evenly by length, and its directions by angle.
    least
        Least tilt of one that comes to the side, degrees: poses fill the ring between both.

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
        return _disc(spec.n_presses, (least, most), spec.seed, lies)
    if offset is not None:
        raise PalpateError(
            f"The protocol {spec.poses} is one of tilts up to 12°.",
            "Choose the poses 'disc'.",
            code="protocol-not-for-obstacle",
        )
    tilt, azimuth = np.meshgrid(PAPER_TILTS_DEG, PAPER_AZIMUTHS_DEG[spec.poses], indexing="ij")
    return rotation_vector(tilt.ravel(), np.deg2rad(azimuth.ravel()))


def _disc(n: int, radii: tuple[float, float], seed: int, by_radius: bool) -> FloatArray:
    """Evenly by area, or by radius: a Kronecker sequence on the unit square, shifted at random, bent into a disc.

    It is a ring where the least radius is not zero.
    """
    least, most = radii
    start = generator(seed, "poses").random(2)
    steps = np.array([1.0 / PLASTIC_NUMBER, 1.0 / PLASTIC_NUMBER**2])
    square = (start + np.arange(n)[:, None] * steps) % 1.0
    share = square[:, 0] if by_radius else np.sqrt(square[:, 0])
    radius = np.sqrt(least**2 + (most**2 - least**2) * square[:, 0]) if least else most * share
    return rotation_vector(radius, np.deg2rad(360.0 * square[:, 1]))
