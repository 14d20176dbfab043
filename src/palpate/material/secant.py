"""Stiffness at small strain: comparison of the data with a fit.

A fit over the whole range of a soft elastomer may have R² 0.999 and twice the true modulus at small strain, since the
squares of large stresses dominate; but a sensor works at small strains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate.material.fit import Fit
from palpate.material.sample import Loading, Sample

STRAIN = 0.1
"""Strain to which the secant is drawn. By hand."""
_NEAR = 0.5
"""Share of that strain within which rows count for the secant. By hand."""
_FEWEST = 3
"""Minimum number of rows of a secant by a parabola. By hand."""
SECANT_TOLERANCE = 0.15
"""Maximum relative difference between the secants of fit and data: that between two test machines."""


@dataclass(frozen=True)
class Secant:
    """Secant moduli of the samples of one test and of a fit, at 10 % of strain.

    Attributes
    ----------
    loading
        The test.
    measured, fitted
        Nominal stress over strain, MPa; of the data, the median of the samples.
    """

    loading: Loading
    measured: float
    fitted: float

    @property
    def excess(self) -> float:
        """Relative excess of the fit's stiffness over the data's."""
        return self.fitted / self.measured - 1


def compare_secants(samples: Sequence[Sample], fit: Fit) -> tuple[Secant, ...]:
    """Compare the secants at 10 % of every test measured there; tension and compression separately.

    Parameters
    ----------
    samples
        Those that were fitted, thinned or not.
    fit
        Their fit.

    Returns
    -------
    tuple of Secant
        None for a test with too few rows about that strain, or without a positive modulus.
    """
    found = []
    for loading in dict.fromkeys(sample.loading for sample in samples):
        for side in (1, -1):
            each = [_secant(sample, side) for sample in samples if sample.loading is loading]
            known = [value for value in each if value is not None]
            if not known or not np.median(known) > 0:
                continue
            mode = samples[[sample.loading for sample in samples].index(loading)].mode
            fitted = float(fit.nominal(mode, np.array([1 + side * STRAIN]))[0]) / (side * STRAIN)
            named = {1: Loading.TENSION, -1: Loading.COMPRESSION}[side] if loading is Loading.UNIAXIAL else loading
            found.append(Secant(named, float(np.median(known)), fitted))
    return tuple(found)


def _secant(sample: Sample, side: int) -> float | None:
    """Stress at 10 % of strain over that strain, MPa, by a parabola through rest and the rows about it."""
    strain = side * (sample.stretch - 1)
    near = (strain > STRAIN * (1 - _NEAR)) & (strain < STRAIN * (1 + _NEAR))
    if near.sum() >= _FEWEST:
        x, y = strain[near], side * sample.nominal[near]
        line = np.linalg.lstsq(np.column_stack([x, x * x]), y, rcond=None)[0]
        return float(line[0] + line[1] * STRAIN)
    below, above = strain[(strain >= 0) & (strain <= STRAIN)], strain[strain > STRAIN]
    if not len(above) or (not len(below) and above.min() > 2 * STRAIN):
        return None
    order = np.argsort(strain, kind="stable")
    order = order[strain[order] > 0]
    x, y = np.append(0.0, strain[order]), np.append(0.0, side * sample.nominal[order])
    return float(np.interp(STRAIN, x, y)) / STRAIN
