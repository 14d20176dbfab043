"""Drucker's stability: an increment of strain must need work against the stress that it causes.

With the third direction free of stress, ``d tau_i = D_ij d eps_j`` for ``tau = (tau_1 - tau_3, tau_2 - tau_3)`` and
the two free logarithmic strains; the law is stable while D is positive definite. In principal axes the spatial
tangent is ``c_ij = d tau_i / d eps_j - 2 tau_i delta_ij``, so D follows from the tangent of the elements.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray
from palpate.material.curve import Mode, stretches
from palpate.material.law import Law

LOW, HIGH = 0.05, 20.0
"""Uniaxial stretches between which a law is scanned, if data do not go further. By hand."""
_POINTS = 400
"""Stretches of the scan on either side of rest, evenly spaced on a logarithmic scale. By hand."""
_WIDTH = 1e-11
"""Width at which the bisection of the stability limit ends. By hand."""
_ROUNDING = 1e-12
"""Relative rounding of the smallest eigenvalue (Ogden's law with a large exponent), over the largest."""


@dataclass(frozen=True)
class StableRange:
    """Stretches of one mode between which a law is stable.

    Attributes
    ----------
    mode
        The mode.
    low, high
        First unstable stretch in compression and in tension, or the locking stretch; nan if not found.
    low_locks, high_locks
        Whether the law locks there, so that it has no stress beyond.
    """

    mode: Mode
    low: float
    high: float
    low_locks: bool = False
    high_locks: bool = False

    @property
    def whole(self) -> bool:
        """Whether the scan met neither an instability nor a stretch at which the law locks."""
        return bool(np.isnan(self.low) and np.isnan(self.high))

    @property
    def stable(self) -> bool:
        """Whether the law is stable up to the stretch at which it locks."""
        return bool((np.isnan(self.low) or self.low_locks) and (np.isnan(self.high) or self.high_locks))


def drucker_matrix(law: Law, principal: FloatArray) -> FloatArray:
    """Drucker's matrices (n, 2, 2) MPa in principal stretches (n, 3) of volume 1; nan where the law locks."""
    energy, tau, c = law.isochoric(np.ascontiguousarray(principal[:, :, None] * np.eye(3)))
    slope = c[:, :3, :3] + 2 * tau[:, :3, None] * np.eye(3)
    against_third = slope[:, :2] - slope[:, 2:]
    matrix: FloatArray = against_third[:, :, :2] - against_third[:, :, 2:]
    matrix[~np.isfinite(energy)] = np.nan
    return matrix


def find_stable_ranges(law: Law, low: float = LOW, high: float = HIGH) -> tuple[StableRange, ...]:
    """Find the stretch at which a law loses Drucker's stability, or locks, in each mode.

    Parameters
    ----------
    law
        The law.
    low, high
        Ends of the scan in uniaxial stretch, below and above 1.
    """
    ends = {mode: scan_ends(mode, low, high) for mode in Mode}
    found = []
    for mode in Mode:
        (low, low_locks), (high, high_locks) = (_first_unstable(law, mode, end) for end in ends[mode])
        found.append(StableRange(mode, low, high, low_locks, high_locks))
    return tuple(found)


def scan_ends(mode: Mode, low: float, high: float) -> tuple[float, float]:
    """Ends of a scan of each mode that reaches as far as the uniaxial stretches low and high.

    Equibiaxial tension to ``low**-0.5`` is uniaxial compression to `low`; the planar mode goes from ``1 / high`` to
    `high`.
    """
    if mode is Mode.EQUIBIAXIAL:
        return high**-0.5, low**-0.5
    return (low, high) if mode is Mode.UNIAXIAL else (1 / high, high)


def _first_unstable(law: Law, mode: Mode, end: float) -> tuple[float, bool]:
    """Find the first unstable or locking stretch towards an end (nan if none), and whether it locks."""
    path = end ** np.linspace(0.0, 1.0, _POINTS)
    least = _least(law, mode, path)
    ended = np.flatnonzero(~(least > 0))
    if not len(ended):
        return float("nan"), False
    first = int(ended[0])
    if first == 0:
        return 1.0, False
    good, bad = float(path[first - 1]), float(path[first])
    while abs(bad - good) > _WIDTH:
        middle = 0.5 * (good + bad)
        value = float(_least(law, mode, np.array([middle]))[0])
        good, bad = (middle, bad) if value > 0 else (good, middle)
    return bad, bool(np.isnan(_least(law, mode, np.array([bad]))[0]))


def _least(law: Law, mode: Mode, stretch: FloatArray) -> FloatArray:
    """Smallest eigenvalue (n,) of Drucker's matrix, MPa; nan where chains lock."""
    matrix = drucker_matrix(law, stretches(mode, stretch))
    middle = 0.5 * (matrix[:, 0, 0] + matrix[:, 1, 1])
    radius = np.hypot(0.5 * (matrix[:, 0, 0] - matrix[:, 1, 1]), matrix[:, 0, 1])
    return np.asarray(middle - radius + _ROUNDING * (np.abs(middle) + radius))
