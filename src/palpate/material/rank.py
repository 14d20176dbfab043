"""Ranking models: which one describes the samples best, and what a fit may say about tests that were not made."""

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
"""A model is a peer if its error is at most so many times that of the best."""
_SHARE, _BENCHES, _UPPER = 0.7, 0.05, 3.0
"""Error to reckon with: share of the distance between models, and what differs between benches where models agree
altogether; upper end over that. Fitted to five rubbers and checked by leaving each out (docs/results/materials)."""
_UNDETERMINED = 1e8
"""Condition number beyond which the constants are any of many, and so is what they say of other modes."""
_POINTS = 60
"""Stretches at which models are compared."""


@dataclass(frozen=True)
class Ranked:
    """One model among the others.

    Attributes
    ----------
    name
        Model.
    fit
        Its fit; none where there is none.
    delta_aicc
        Akaike's criterion above that of the best: beyond 10 the data speak against the model.
    left_out
        RMSE over the greatest stress of samples that were left out of the fit in turn; nan with one sample.
    failure
        Why there is no fit.
    """

    name: str
    fit: Fit | None
    delta_aicc: float
    left_out: float
    failure: str = ""


@dataclass(frozen=True)
class ModeExtrapolation:
    """What a fit may miss in a mode that was not measured.

    Attributes
    ----------
    mode
        The mode.
    high
        Stretch to which it is judged: that of the greatest I1 measured.
    between
        Median distance from the other models that fit about as well: RMS over their greatest stress; nan without
        any, and where the data do not determine the constants.
    relative
        Error to reckon with, RMS over the greatest stress; nan where `between` is.
    upper
        Upper end of that error, met by nine fits in ten or more.
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
    """Error in predicting each sample by a fit to the others: RMS over samples, each over its greatest stress.

    nan with fewer than two samples or where the others are too few rows for the model.
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
    """Predict how far a fit may be off in the modes that were not measured.

    Models that describe the measured modes about as well and are stable differ where nothing was measured. Since most
    models are functions of I1 alone and would agree by construction, a Yeoh with a term in I2 joins them. That models
    agree is no evidence, and two tests of one rubber differ by some 15 %, so the error to reckon with is never less
    than 5 %, its upper end never less than 15 %:

        relative = sqrt((0.7 between)² + 0.05²),   upper = 3 relative

    It is an order of magnitude, no bound: docs/results/materials says how it does on five rubbers.

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
    """The stable fit of Yeoh's law with a term in I2; empty where there is none."""
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
