"""What matters about a skin: shares of the error's variance over the searched space that each variable explains.

Sobol's indices (Sobol 2001, doi 10.1016/S0378-4754(00)00270-6) of a smooth surface through what was tried: as good as
that surface is, whose error at skins left out is stated beside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.stats import sobol_indices, uniform

from palpate.core import FloatArray
from palpate.optimise.front import SkinTrial
from palpate.optimise.space import SkinSpace

_FEWEST = 4
"""Skins for each variable below which nothing is said."""
_LEAST_EXPLAINED = 0.5
"""Share of the variance of skins left out below which a surface says nothing of what matters."""
_SMOOTHING = 1e-3
_SAMPLES = 1024


@dataclass(frozen=True)
class SobolIndex:
    """How much of the error's spread a variable explains.

    Attributes
    ----------
    name
        Of the variable.
    first_order, total
        Sobol's first and total index: by itself, and with all that it does together with others.
    """

    name: str
    first_order: float
    total: float


@dataclass(frozen=True)
class SobolIndices:
    """What matters in a search.

    Attributes
    ----------
    variables
        The most important first; empty where too few skins were tried.
    explained
        Share of the variance of skins left out, a tenth at a time, that the surface explains; 1 is all.
    """

    variables: tuple[SobolIndex, ...]
    explained: float

    @property
    def summary(self) -> str:
        """What matters and what does not, in plain words."""
        if not self.variables:
            return "Too few skins were tried to say what matters."
        if self.explained < _LEAST_EXPLAINED:
            return "What matters cannot be told: no smooth surface goes through the skins tried."
        matter = [one.name for one in self.variables if one.total >= 0.15]
        idle = [one.name for one in self.variables if one.total < 0.05]
        words = f"What matters most: {', '.join(matter) or 'nothing by itself'}."
        return words + (f" What hardly matters: {', '.join(idle)}." if idle else "")


def compute_sobol_indices(tried: Sequence[SkinTrial], space: SkinSpace, markers: int, seed: int = 0) -> SobolIndices:
    """Sobol's indices of the log of the least error over the ranges of a space, by skins that reach the depth.

    The error of a skin that does not reach it is that of other poses, up to some times as large.
    """
    names, rows, values = list(space.ranges), [], []
    for one in tried:
        best = one.coarse.best(markers)
        if best is not None and one.violations.get("reach", 0.0) <= 0.0:
            rows.append(_unit_place(space, one))
            values.append(log10(best.accuracy.p95_deg))
    x, y = np.array(rows), np.array(values)
    if not names or len(y) < _FEWEST * len(names) + 2 or np.ptp(y) == 0:
        return SobolIndices((), 0.0)
    explained = _explained(x, y)
    surface = _surface(x, y)
    found = sobol_indices(
        func=lambda points: surface(points.T)[None, :],
        n=_SAMPLES,
        dists=[uniform()] * len(names),
        rng=np.random.default_rng(seed),
    )
    first, total = np.ravel(found.first_order), np.ravel(found.total_order)
    variables = [SobolIndex(name, float(a), float(b)) for name, a, b in zip(names, first, total, strict=True)]
    return SobolIndices(tuple(sorted(variables, key=lambda one: -one.total)), explained)


def _unit_place(space: SkinSpace, one: SkinTrial) -> list[float]:
    place = space.place(one.coarse.skin)
    return [(float(place[name]) - low) / (high - low) for name, (low, high) in space.ranges.items()]


def _surface(x: FloatArray, y: FloatArray) -> RBFInterpolator:
    return RBFInterpolator(x, y, kernel="thin_plate_spline", smoothing=_SMOOTHING)


def _explained(x: FloatArray, y: FloatArray) -> float:
    """Share of the variance explained where each tenth is left out in turn."""
    left = np.empty_like(y)
    for part in range(10):
        out = np.arange(len(y)) % 10 == part
        if out.any():
            left[out] = y[out] - _surface(x[~out], y[~out])(x[out])
    return float(1.0 - np.mean(left**2) / np.var(y))
