"""Ranking of models by their fit to samples, and their extrapolation to modes that were not measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from palpate.core import FloatArray, PalpateError
from palpate.material.curve import Mode, stretches
from palpate.material.fit import Fit
from palpate.material.fit_material import fit_rows
from palpate.material.make_law import SECOND_INVARIANT, list_models
from palpate.material.sample import Sample
from palpate.material.spec import FitSpec

_AS_GOOD = 10.0
"""Maximum ratio of a peer model's error to that of the best model. By hand."""
_SHARE, _BENCHES, _UPPER = 0.7, 0.05, 3.0
"""Error estimate: share of the distance of models, difference of machines, ratio of the upper end.

Fitted to five rubbers and checked by leaving each out (docs/results/materials).
"""
_UNDETERMINED = 1e8
"""Condition number beyond which the data do not determine the constants. By hand."""
_POINTS = 60
"""Stretches at which models are compared. By hand."""


@dataclass(frozen=True)
class Ranked:
    """Rank of one model.

    Attributes
    ----------
    name
        Model.
    fit
        Its fit; `None` if it failed.
    delta_aicc
        Akaike's criterion above that of the best: beyond 10 the data contradict the model.
    left_out
        RMSE over the maximum stress of samples that were left out of the fit in turn; nan with one sample.
    failure
        Reason for a missing fit.
    """

    name: str
    fit: Fit | None
    delta_aicc: float
    left_out: float
    failure: str = ""


@dataclass(frozen=True)
class ModeExtrapolation:
    """Error estimate of a fit in a mode that was not measured.

    Attributes
    ----------
    mode
        The mode.
    high
        Maximum stretch of the estimate: that of the maximum measured I1.
    between
        Median distance from the peer models: RMS over their maximum stress; nan without peers, and if the data do not
        determine the constants.
    relative
        Error estimate, RMS over the maximum stress; nan with `between`.
    upper
        Upper end of that error, valid for at least 90 % of the fits.
    peers
        Their names.
    """

    mode: Mode
    high: float
    between: float
    relative: float
    upper: float
    peers: tuple[str, ...]


def rank_models(
    samples: Sequence[Sample], spec: FitSpec | None = None, names: Sequence[str] | None = None
) -> tuple[Ranked, ...]:
    """Fit models and rank them by Akaike's criterion, the best first; those that cannot be fitted last.

    Parameters
    ----------
    samples, spec
        As for `fit_material`; the model of the spec does not matter.
    names
        Models; without them, all.
    """
    spec = spec or FitSpec()
    found = []
    for name in list_models() if names is None else names:
        chosen = spec.model_copy(update={"model": name})
        try:
            fit = fit_rows(samples, chosen)
        except PalpateError as error:
            found.append(Ranked(name, None, float("inf"), float("nan"), error.problem))
            continue
        found.append(Ranked(name, fit, fit.aicc, leave_out_error(samples, fit)))
    best = min((item.delta_aicc for item in found), default=0.0)
    if np.isfinite(best):
        found = [replace(item, delta_aicc=item.delta_aicc - best) for item in found]
    return tuple(sorted(found, key=lambda item: item.delta_aicc))


def leave_out_error(samples: Sequence[Sample], fit: Fit) -> float:
    """Error in predicting each sample by a fit to the remaining ones: RMS over samples, each normalised.

    Each error is divided by the sample's maximum stress. nan with fewer than two samples or too few rows for the
    model.
    """
    if len(samples) < 2:
        return float("nan")
    squares = []
    for at, sample in enumerate(samples):
        try:
            other = fit_rows([*samples[:at], *samples[at + 1 :]], fit.spec, near=fit)
        except PalpateError:
            return float("nan")
        with np.errstate(over="ignore", invalid="ignore"):
            error = other.nominal_of(sample) - sample.nominal
            squares.append(float(np.mean((error / np.abs(sample.nominal).max()) ** 2)))
    return float(np.sqrt(np.mean(squares)))


def extrapolate_modes(fit: Fit, ranked: Sequence[Ranked], samples: Sequence[Sample]) -> tuple[ModeExtrapolation, ...]:
    """Estimate the error of a fit in the modes that were not measured.

    Models that describe the measured modes about equally well and are stable differ elsewhere. Since most models are
    functions of I1 alone and would agree by construction, Yeoh's law with a term in I2 joins them. Agreement of
    models is no evidence, and two tests of one rubber differ by some 15 %, so the estimate is at least 5 %, its upper
    end at least 15 %:

        relative = sqrt((0.7 between)² + 0.05²),   upper = 3 relative

    It is an order of magnitude, not a bound; docs/results/materials compares it with five rubbers.

    Parameters
    ----------
    fit
        The fit.
    ranked
        Other models fitted to the same samples.
    samples
        These samples.
    """
    others = [item.fit for item in ranked if item.fit is not None and item.fit.model.name != fit.model.name]
    others += _fit_second_invariant(samples, fit.spec)
    best = min(_error(other) for other in [fit, *others])
    peers = [other for other in others if other.stable and _error(other) <= _AS_GOOD * best]
    greatest = max(_stretch_energy(q.mode, end) for q in fit.quality for end in (q.low, q.high))
    found = []
    for mode in Mode:
        if mode in (item.mode for item in fit.quality):
            continue
        high = float(brentq(lambda end, mode=mode: _stretch_energy(mode, end) - greatest, 1.0, 100.0))
        grid = np.linspace(1.0, high, _POINTS)
        with np.errstate(over="ignore", invalid="ignore"):
            own = fit.nominal(mode, grid)
            distances = [_distance(own, peer.nominal(mode, grid)) for peer in peers]
        known = distances and fit.condition < _UNDETERMINED
        between = float(np.median(distances)) if known else float("nan")
        relative = float(np.hypot(_SHARE * between, _BENCHES))
        names = tuple(peer.model.name for peer in peers)
        found.append(ModeExtrapolation(mode, high, between, relative, _UPPER * relative, names))
    return tuple(found)


def _distance(own: FloatArray, other: FloatArray) -> float:
    return float(np.sqrt(np.mean((own - other) ** 2)) / np.abs(other).max())


def _fit_second_invariant(samples: Sequence[Sample], spec: FitSpec) -> list[Fit]:
    """The stable fit of Yeoh's law with a term in I2; empty if it does not exist."""
    chosen = spec.model_copy(update={"model": SECOND_INVARIANT.name, "stable": True})
    try:
        return [fit_rows(samples, chosen)]
    except PalpateError:
        return []


def _error(fit: Fit) -> float:
    """Root of the mean weighted square."""
    return float(np.sqrt(fit.objective / fit.count))


def _stretch_energy(mode: Mode, stretch: float) -> float:
    """``I1 - 3``."""
    return float((stretches(mode, np.array([stretch])) ** 2).sum() - 3)
