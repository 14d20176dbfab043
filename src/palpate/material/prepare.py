"""Preparation of curves: cut at break, toe compensation, trimming, thinning; mean of samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.material.loading import loading_branch
from palpate.material.read_test_file import LEAST_ROWS
from palpate.material.sample import Loading, Sample
from palpate.material.spec import PrepareSpec

_TOE, _TOE_STRAIN = 0.15, 0.15
"""Share of the strain within which a toe is sought, and maximum strain of a toe. By hand."""
_TOE_WINDOW = 5
"""Rows over which the slope of a toe is taken. By hand."""


@dataclass(frozen=True)
class AverageCurve:
    """Mean of the samples of one test over their common range.

    Attributes
    ----------
    loading
        The test.
    stretch
        (n,).
    mean, spread
        (n,) MPa: mean of the nominal stress, and standard deviation between the samples (nan with one sample).
    count
        Samples.
    """

    loading: Loading
    stretch: FloatArray
    mean: FloatArray
    spread: FloatArray
    count: int


def prepare_sample(sample: Sample, spec: PrepareSpec) -> Sample:
    """Prepare one sample.

    Parameters
    ----------
    sample
        As read.
    spec
        In this order: cut at break or unloading, compensate the toe, correct the strain, trim, average to fewer rows.

    Raises
    ------
    PalpateError
        If fewer than five rows are left.
    """
    notes = list(sample.notes)
    read = len(sample.stretch)
    if spec.until_break:
        sample = loading_branch(sample)
        if len(sample.stretch) < read:
            notes.append(f"{read - len(sample.stretch)} rows after break or unloading left out")
    if spec.toe == "auto":
        offset = toe_offset(sample)
        sample = replace(sample, stretch=sample.stretch - offset)
        notes.append(f"toe: strain shifted by {-offset:+.4f}")
    if spec.strain_factor != 1:
        sample = replace(sample, stretch=1 + spec.strain_factor * (sample.stretch - 1))
        notes.append(f"strain times {spec.strain_factor:g}")
    sample = sample.where((sample.stretch >= spec.min_stretch) & (sample.stretch <= spec.max_stretch))
    if len(sample.stretch) < LEAST_ROWS:
        raise PalpateError(
            f"{sample.name}: {len(sample.stretch)} rows are left between stretch {spec.min_stretch:g} and "
            f"{spec.max_stretch:g}.",
            "Widen the range.",
            code="samples-few-rows-left",
        )
    if spec.points is not None and len(sample.stretch) > spec.points:
        sample = _thin(sample, spec.points)
    return replace(sample, notes=tuple(notes))


def toe_offset(sample: Sample) -> float:
    """Strain at which the steepest line of a curve's first part meets zero stress (ASTM D638, annex A1).

    Zero if the curve is steepest at its start: it has no toe.
    """
    strain, stress = np.abs(sample.stretch - 1), np.abs(sample.nominal)
    first = strain <= strain.min() + min(_TOE * np.ptp(strain), _TOE_STRAIN)
    order = np.argsort(strain[first], kind="stable")
    strain, stress = strain[first][order], stress[first][order]
    starts = range(len(strain) - _TOE_WINDOW + 1)
    lines = [np.polyfit(strain[at : at + _TOE_WINDOW], stress[at : at + _TOE_WINDOW], 1) for at in starts]
    if len(lines) < 2:
        return 0.0
    slope, height = max(lines, key=lambda line: line[0])
    offset = -height / slope if slope > 0 else 0.0
    if not 0 < offset < strain[-1]:
        return 0.0
    return float(np.copysign(offset, sample.stretch[np.argmax(np.abs(sample.stretch - 1))] - 1))


def average_samples(samples: Sequence[Sample], points: int = 60) -> AverageCurve:
    """Average the samples of one test over the stretches that all of them reach.

    Parameters
    ----------
    samples
        At least one, all of one loading.
    points
        Stretches of the mean.

    Raises
    ------
    PalpateError
        If the samples have no stretch in common.
    """
    low = max(sample.stretch.min() for sample in samples)
    high = min(sample.stretch.max() for sample in samples)
    if not low < high:
        names = ", ".join(sample.name for sample in samples)
        raise PalpateError(
            f"{names} have no stretch in common.", "Average samples of one test.", code="samples-no-common-stretch"
        )
    grid = np.linspace(low, high, points)
    curves = []
    for sample in samples:
        order = np.argsort(sample.stretch, kind="stable")
        curves.append(np.interp(grid, sample.stretch[order], sample.nominal[order]))
    spread = np.std(curves, axis=0, ddof=1) if len(curves) > 1 else np.full(points, np.nan)
    return AverageCurve(samples[0].loading, grid, np.mean(curves, axis=0), spread, len(samples))


def _thin(sample: Sample, points: int) -> Sample:
    """Means of the rows in even bins of stretch."""
    edges = np.linspace(sample.stretch.min(), sample.stretch.max(), points + 1)
    bin_of = np.clip(np.searchsorted(edges, sample.stretch, side="right") - 1, 0, points - 1)
    count = np.bincount(bin_of, minlength=points)
    filled = count > 0
    stretch, nominal = (
        np.bincount(bin_of, values, points)[filled] / count[filled] for values in (sample.stretch, sample.nominal)
    )
    return replace(sample, stretch=stretch, nominal=nominal)
