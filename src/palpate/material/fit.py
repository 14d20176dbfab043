"""Fitted constants of a law, with confidence intervals, quality and range of stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from palpate.core import FloatArray
from palpate.material.curve import Mode, stretches, uniaxial_range
from palpate.material.drucker import StableRange, find_stable_ranges
from palpate.material.law import Law, Model
from palpate.material.material import DEFAULT_BULK_RATIO, Material
from palpate.material.sample import Sample
from palpate.material.spec import FitSpec


@dataclass(frozen=True)
class ModeQuality:
    """Quality of a law for the samples of one mode.

    Attributes
    ----------
    mode
        The mode.
    count
        Rows.
    low, high
        Stretches measured.
    r2
        ``1 - SSE / SST`` of nominal stress, SST about the mean of the rows.
    rmse
        MPa.
    relative
        RMSE over the maximum measured stress.
    """

    mode: Mode
    count: int
    low: float
    high: float
    r2: float
    rmse: float
    relative: float


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes
    ----------
    spec
        Settings of the fit.
    model
        The model.
    linear, shapes
        Its constants: (k,) MPa and (k,) or (0,).
    intervals
        (p, 2) confidence intervals of all constants, linear ones first; nan if a bound or the stability constrains
        the fit, which least-squares theory does not cover.
    objective
        Weighted sum of squared residuals; MPa² with uniform weights.
    condition
        Condition number of the weighted sensitivities, each column scaled to length 1: above about 1e3 the data do
        not separate the constants.
    count
        Rows fitted.
    aicc
        Akaike's criterion with the correction for few rows; comparable between fits to the same rows and weights.
    quality
        By mode measured.
    scanned
        Uniaxial stretches between which `stability` is scanned.
    held
        Whether a bound or the stability constrains the fit.
    from_samples
        Whether the intervals come from the differences between samples, not from those between rows.
    """

    spec: FitSpec
    model: Model
    linear: FloatArray
    shapes: FloatArray
    intervals: FloatArray
    objective: float
    condition: float
    count: int
    aicc: float
    quality: tuple[ModeQuality, ...]
    scanned: tuple[float, float]
    held: bool
    from_samples: bool

    @property
    def law(self) -> Law:
        """The law."""
        return self.model.law(self.linear, self.shapes)

    @property
    def constants(self) -> dict[str, float]:
        """All constants by name, linear ones first."""
        values = (float(value) for value in (*self.linear, *self.shapes))
        return dict(zip(self.model.constants, values, strict=True))

    @cached_property
    def stability(self) -> tuple[StableRange, ...]:
        """Stability limit or locking stretch of each mode."""
        return find_stable_ranges(self.law, *self.scanned)

    @property
    def stable(self) -> bool:
        """Whether no mode loses Drucker's stability within the scan, up to locking."""
        return all(item.stable for item in self.stability)

    def nominal(self, mode: Mode, stretch: FloatArray) -> FloatArray:
        """Nominal stress (n,) MPa in one mode at stretches (n,)."""
        return np.asarray(self.model.terms(stretches(mode, stretch), self.shapes) @ self.linear)

    def nominal_of(self, sample: Sample) -> FloatArray:
        """Nominal stress (n,) MPa at the stretches of a sample."""
        return self.nominal(sample.mode, sample.stretch)

    def material(self, name: str, source: str = "", licence: str = "") -> Material:
        """Make the material, with the range and quality of this fit.

        Raises
        ------
        PalpateError
            If its initial shear modulus is not positive.
        """
        ends = [uniaxial_range(item.mode, item.low, item.high) for item in self.quality]
        quality = "; ".join(
            f"{item.mode} {item.low:.3g}…{item.high:.3g}: R² {item.r2:.5f}, rms {1e3 * item.rmse:.3g} kPa"
            for item in self.quality
        )
        held = "; held to Drucker's stability" if self.spec.stable else ""
        return Material(
            name=name,
            law=self.law,
            bulk_ratio=DEFAULT_BULK_RATIO,
            source=source,
            stretch_range=(min(low for low, _ in ends), max(high for _, high in ends)),
            licence=licence,
            quality=f"{quality}; {self.count} rows, {self.spec.weighting} weights{held}",
        )


def assess_fit(samples: Sequence[Sample], predicted: Sequence[FloatArray]) -> tuple[ModeQuality, ...]:
    """Compute the quality of predicted nominal stresses, (n,) each, by mode of the samples."""
    found = []
    for mode in Mode:
        chosen = [at for at, sample in enumerate(samples) if sample.mode is mode]
        if not chosen:
            continue
        stretch = np.concatenate([samples[at].stretch for at in chosen])
        measured = np.concatenate([samples[at].nominal for at in chosen])
        error = np.concatenate([predicted[at] for at in chosen]) - measured
        rmse = float(np.sqrt(np.mean(error**2)))
        r2 = float(1 - np.sum(error**2) / np.sum((measured - measured.mean()) ** 2))
        relative = rmse / float(np.abs(measured).max())
        ends = float(stretch.min()), float(stretch.max())
        found.append(ModeQuality(mode, len(stretch), *ends, r2, rmse, relative))
    return tuple(found)
