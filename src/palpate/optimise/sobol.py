"""Sobol indices of a search: share of the error's variance that each variable explains.

Indices (Sobol 2001, doi 10.1016/S0378-4754(00)00270-6) of a smooth surface fitted to the trials. The cross-validated
error of the surface is reported with them.
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
"""Minimum number of skins per variable for a result. By hand."""
_LEAST_EXPLAINED = 0.5
"""Minimum explained share of the cross-validated variance for a statement on importance. By hand."""
_SMOOTHING = 1e-3
"""Smoothing of the spline through the evaluated skins (`RBFInterpolator`). By hand."""
_SAMPLES = 1024
"""Samples of a variable in Saltelli's scheme, a power of two for the Sobol sequence. By hand."""


@dataclass(frozen=True)
class SobolIndex:
    """Sobol indices of one variable.

    Attributes
    ----------
    name
        Name of the variable.
    first_order, total
        First-order index (the variable by itself) and total index (with all its interactions).
    """

    name: str
    first_order: float
    total: float


@dataclass(frozen=True)
class SobolIndices:
    """Sobol indices of a search.

    Attributes
    ----------
    variables
        In descending order of importance; empty if there are too few trials.
    explained
        Share of the variance that the surface explains in ten-fold cross-validation; 1 is all.
    """

    variables: tuple[SobolIndex, ...]
    explained: float

    @property
    def summary(self) -> str:
        """Important and unimportant variables, as a sentence."""
        if not self.variables:
            return "Too few skins were tried to rank the variables."
        if self.explained < _LEAST_EXPLAINED:
            return "The variables cannot be ranked: no smooth surface fits the skins that were tried."
        matter = [one.name for one in self.variables if one.total >= 0.15]
        idle = [one.name for one in self.variables if one.total < 0.05]
        words = f"Most important: {', '.join(matter) or 'no single variable'}."
        return words + (f" Unimportant: {', '.join(idle)}." if idle else "")


def compute_sobol_indices(tried: Sequence[SkinTrial], space: SkinSpace, markers: int, seed: int = 0) -> SobolIndices:
    """Compute Sobol indices of the log of the minimum error, by the skins that reach the required depth.

    The error of a skin that does not reach the depth refers to other poses and may be several times as large.
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
    """Share of the variance explained in ten-fold cross-validation."""
    left = np.empty_like(y)
    for part in range(10):
        out = np.arange(len(y)) % 10 == part
        if out.any():
            left[out] = y[out] - _surface(x[~out], y[~out])(x[out])
    return float(1.0 - np.mean(left**2) / np.var(y))
