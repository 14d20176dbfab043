"""Fit of a Prony series to relaxation tests, by the response to the measured strain.

The response of each term to a piecewise linear strain history is known in closed form. Rows are averaged over equal
intervals of log time, so that the first second has the weight of an hour. Constants are at least zero and start from
non-negative least squares on a dense grid of times, whose neighbours are merged. Akaike's criterion selects the
number of terms, at most one a decade.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares, nnls
from scipy.special import stdtrit

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError
from palpate.material.relaxation import MOST_TERMS, Moduli, Relaxation
from palpate.material.relaxation_test import RelaxationTest

_BINS_PER_DECADE, _GRID_PER_DECADE = 20, 10
"""Means of the data, and relaxation times of a first fit, per decade of time. By hand."""
_KNOT = 0.01
"""Maximum error of the piecewise linear strain history, over the held strain. By hand."""
_LEAST_WEIGHED = 0.2
"""Minimum stress of the weights, over a test's maximum stress. By hand."""
_AT_BOUND = 1e-4
"""Strength up to which a term is at its bound. By hand."""
_LEAST_END = 1e-3
"""Minimum long-term share that is distinguished from a slow term. By hand."""


@dataclass(frozen=True)
class RelaxationFit:
    """Result of a fit to relaxation tests.

    Attributes
    ----------
    relaxation
        The series.
    intervals
        (2 k, 2) confidence intervals of the shares and then of the times (s), from the differences between rows; nan
        if a bound constrains a term.
    confidence
        Level of the intervals.
    first, last
        Range of the tests, s since the strain began.
    max_error, rms
        Maximum and RMS difference between fit and rows averaged over log time, relative to their stress, during the
        hold.
    tried
        By number of terms: Akaike's criterion and the maximum difference of the fit.
    count
        Averaged rows.
    """

    relaxation: Relaxation
    intervals: FloatArray
    confidence: float
    first: float
    last: float
    max_error: float
    rms: float
    tried: tuple[tuple[int, float, float], ...]
    count: int


@dataclass(frozen=True, eq=False)
class _Rows:
    """Averaged rows of one test: normalised stress, weights, and the responses of a term to its strain."""

    stress: FloatArray
    weight: FloatArray
    held: BoolArray
    passed: FloatArray
    rates: FloatArray
    lengths: FloatArray
    bins: IntArray
    answers: dict[float, FloatArray] = field(default_factory=dict)

    def answer(self, times: FloatArray) -> FloatArray:
        """Responses (n, 1 + k): of the part that does not relax, and of terms of these times (k,) s."""
        return np.column_stack([self._term(float(time)) for time in [np.inf, *times]])

    def _term(self, time: float) -> FloatArray:
        """Cached response (n,) of one term."""
        if time not in self.answers:
            begun = np.maximum(self.passed, 0.0)  # (rows, pieces): since a piece began, and since it ended
            ended = np.maximum(self.passed - self.lengths, 0.0)
            if np.isinf(time):
                each = np.where(self.lengths > 0, begun - ended, (self.passed >= 0).astype(float))
            else:
                ramp = time * (np.exp(-ended / time) - np.exp(-begun / time))
                each = np.where(self.lengths > 0, ramp, np.where(self.passed >= 0, np.exp(-begun / time), 0.0))
            self.answers[time] = np.bincount(self.bins, each @ self.rates) / np.bincount(self.bins)
        return self.answers[time]


def fit_relaxation(
    tests: Sequence[RelaxationTest],
    confidence: float = 0.95,
    moduli: Moduli = Moduli.LONG_TERM,
    terms: int | None = None,
) -> RelaxationFit:
    """Fit one Prony series to all tests; each may have its own strain.

    Parameters
    ----------
    tests
        At least one.
    confidence
        Level of the intervals.
    moduli
        Time at which the constants of the material's law hold.
    terms
        Number of terms; chosen by Akaike's criterion if left out.

    Raises
    ------
    PalpateError
        If a test shows no relaxation, there are fewer rows than constants, or the stress does not fall or does not
        level off.
    """
    if not tests:
        raise PalpateError("There are no relaxation tests.", "Give the file of at least one.", code="fit-no-samples")
    if terms is not None and not 1 <= terms <= MOST_TERMS:
        raise PalpateError(
            f"A series of {terms} terms was asked for.", f"Ask for 1 to {MOST_TERMS}.", code="relaxation-term-count"
        )
    for test in tests:
        test.check()
    rows = [_average(test) for test in tests]
    first, last = min(test.first for test in tests), max(test.last for test in tests)
    most = max(1, int(np.ceil(np.log10(last / first) - 1e-9)))
    count = sum(len(each.stress) for each in rows)
    numbers = range(1, most + 1) if terms is None else [terms]
    if count <= len(tests) + 2 * numbers[0]:
        raise PalpateError(
            f"{numbers[0]} terms in {len(tests)} tests have {len(tests) + 2 * numbers[0]} constants, and there are "
            f"{count} rows.",
            "Give more rows or ask for fewer terms.",
            code="fit-few-rows",
        )
    fits = [_fit(rows, number, (first, last)) for number in numbers if count > len(tests) + 2 * number + 2]
    fits = fits or [_fit(rows, numbers[0], (first, last))]
    best = min(fits, key=lambda each: each.aicc)
    return _conclude(
        best, rows, (first, last), confidence, moduli, tuple((len(f.times), f.aicc, f.max_error) for f in fits)
    )


@dataclass(frozen=True, eq=False)
class _Found:
    """Amplitudes of the tests, strengths over the long-term part and times (k,) of the terms, and misfit."""

    amplitudes: FloatArray
    strengths: FloatArray
    times: FloatArray
    jacobian: FloatArray
    objective: float
    aicc: float
    max_error: float
    rms: float


def _average(test: RelaxationTest) -> _Rows:
    """Average rows over equal intervals of log time since the strain began; the ramp is unchanged."""
    begun, whole = test.ramp_times
    after = test.time >= begun
    time, stress = test.time[after] - begun, test.stress[after]
    held = test.time[after] >= whole
    edges = np.geomspace(
        test.first, max(test.last, test.first * 1.001), 2 + int(_BINS_PER_DECADE * np.log10(test.last / test.first))
    )
    place = np.where(held, np.searchsorted(edges, time, side="right"), 0)
    ramp = np.minimum(np.arange(len(time)) * _BINS_PER_DECADE // max(int((~held).sum()), 1), _BINS_PER_DECADE - 1)
    _, bins = np.unique(np.where(held, _BINS_PER_DECADE + place, ramp), return_inverse=True)
    count = np.bincount(bins)
    stress = np.bincount(bins, stress) / count
    stress = stress / stress.max()
    knots = np.column_stack(test.strain_history)
    knots = knots[_knots(*knots.T)]
    if knots[0, 1] > _KNOT:  # it came as a step
        knots = np.vstack([[0.0, 0.0], knots])
    lengths, steps = np.diff(knots[:, 0]), np.diff(knots[:, 1])
    rates = np.where(lengths > 0, steps / np.where(lengths > 0, lengths, 1.0), steps)
    passed = time[:, None] - knots[None, :-1, 0]
    weight = 1 / np.maximum(stress, _LEAST_WEIGHED)
    return _Rows(stress, weight, np.bincount(bins, held) / count > 0.5, passed, rates, lengths, bins)


def _knots(time: FloatArray, strain: FloatArray) -> list[int]:
    """Rows between which the strain is linear to within `_KNOT` (Douglas & Peucker 1973)."""
    kept, open_pieces = {0, len(time) - 1}, [(0, len(time) - 1)]
    while open_pieces:
        low, high = open_pieces.pop()
        if high - low < 2:
            continue
        line = np.interp(time[low : high + 1], time[[low, high]], strain[[low, high]])
        off = np.abs(strain[low : high + 1] - line)
        far = int(np.argmax(off))
        if off[far] > _KNOT:
            kept.add(low + far)
            open_pieces += [(low, low + far), (low + far, high)]
    return sorted(kept)


def _fit(rows: Sequence[_Rows], number: int, ends: tuple[float, float]) -> _Found:
    """Find the best series of this number of terms."""
    starts = [_even_start(number, ends), _merged_start(rows, number, ends)]
    found = [_search(rows, start, ends) for start in starts if start is not None]
    return min(found, key=lambda each: each.objective)


def _even_start(number: int, ends: tuple[float, float]) -> FloatArray:
    """Times (k,) s at the centres of equal intervals of log time."""
    return np.asarray(np.geomspace(*ends, 2 * number + 1)[1::2])


def _merged_start(rows: Sequence[_Rows], number: int, ends: tuple[float, float]) -> FloatArray | None:
    """Times (k,) s of non-negative least squares on a dense grid, with nearest times merged."""
    grid = np.geomspace(*ends, 2 + int(_GRID_PER_DECADE * np.log10(ends[1] / ends[0])))
    A = np.vstack([each.answer(grid) * each.weight[:, None] for each in rows])
    strength = nnls(A, np.concatenate([each.stress * each.weight for each in rows]), maxiter=50 * A.shape[1])[0][1:]
    place, weight = list(np.log(grid[strength > 0])), list(strength[strength > 0])
    if len(place) < number:
        return None
    while len(place) > number:
        at = int(np.argmin(np.diff(place)))
        both = weight[at] + weight[at + 1]
        place[at : at + 2] = [(place[at] * weight[at] + place[at + 1] * weight[at + 1]) / both]
        weight[at : at + 2] = [both]
    return np.asarray(np.exp(place))


def _search(rows: Sequence[_Rows], start: FloatArray, ends: tuple[float, float]) -> _Found:
    """Least squares over amplitudes, strengths and log times, from times (k,) s."""
    k, m = len(start), len(rows)
    guess = _guess(rows, start)

    def rest(values: FloatArray) -> FloatArray:
        strengths, times = values[m : m + k], np.exp(values[m + k :])
        parts = []
        for each, amplitude in zip(rows, values[:m], strict=True):
            fitted = amplitude * (each.answer(times) @ np.concatenate([[1.0], strengths]))
            parts.append((fitted - each.stress) * each.weight)
        return np.concatenate(parts)

    low = np.concatenate([np.full(m, 1e-6), np.zeros(k), np.full(k, np.log(ends[0]))])
    high = np.concatenate([np.full(m, np.inf), np.full(k, 1e6), np.full(k, np.log(ends[1]))])
    found = least_squares(
        rest,
        np.clip(guess, low + 1e-9, high - 1e-9),
        bounds=(low, high),
        x_scale="jac",
        **dict.fromkeys(("xtol", "ftol", "gtol"), 1e-12),
    )
    off = found.fun / np.concatenate([each.weight * each.stress for each in rows])
    held = np.concatenate([each.held for each in rows])
    order = np.argsort(found.x[m + k :])
    objective, free = float(found.fun @ found.fun), len(found.fun)
    constants = m + 2 * k + 1
    aicc = free * np.log(max(objective, 1e-300) / free) + 2 * constants
    aicc += 2 * constants * (constants + 1) / (free - constants - 1) if free > constants + 1 else np.inf
    columns = np.concatenate([np.arange(m), m + order, m + k + order])
    return _Found(
        found.x[:m],
        found.x[m : m + k][order],
        np.exp(found.x[m + k :][order]),
        found.jac[:, columns],
        objective,
        float(aicc),
        float(np.abs(off[held]).max()),
        float(np.sqrt(np.mean(off[held] ** 2))),
    )


def _guess(rows: Sequence[_Rows], times: FloatArray) -> FloatArray:
    """Initial amplitudes, strengths and log times, by non-negative least squares."""
    A = rows[0].answer(times) * rows[0].weight[:, None]
    parts = nnls(A, rows[0].stress * rows[0].weight, maxiter=50 * A.shape[1])[0]
    end = max(parts[0], 0.01 * parts.sum(), 1e-6)
    return np.concatenate([np.full(len(rows), end), parts[1:] / end, np.log(times)])


def _conclude(
    best: _Found,
    rows: Sequence[_Rows],
    ends: tuple[float, float],
    confidence: float,
    moduli: Moduli,
    tried: tuple[tuple[int, float, float], ...],
) -> RelaxationFit:
    whole = 1.0 + best.strengths.sum()
    if 1.0 / whole < _LEAST_END:
        raise PalpateError(
            f"After {ends[1]:.3g} s the stress still falls and does not level off.",
            "Hold longer, until the stress levels off, or cut the rows after the strain is released.",
            code="relaxation-not-levelled",
        )
    kept = best.strengths / whole > _AT_BOUND
    m = len(rows)
    shares, times = best.strengths[kept] / whole, best.times[kept]
    if not len(shares):
        raise PalpateError(
            "The stress does not fall.",
            "Check the columns: a relaxation loses stress while it is held.",
            code="relaxation-not-falling",
        )
    half = _half_widths(best, m, confidence, ends)
    values = np.concatenate([shares, times])
    chosen = np.concatenate([kept, kept])
    half = half[chosen]
    return RelaxationFit(
        Relaxation(tuple(map(float, shares)), tuple(map(float, times)), moduli),
        np.column_stack([values * np.exp(-half), values * np.exp(half)]),
        confidence,
        *ends,
        best.max_error,
        best.rms,
        tried,
        sum(len(each.stress) for each in rows),
    )


def _half_widths(best: _Found, tests: int, confidence: float, ends: tuple[float, float]) -> FloatArray:
    """Half-widths (2 k,) of the intervals of log shares and log times; nan if a bound constrains a term."""
    k = len(best.strengths)
    bound = (best.strengths < _AT_BOUND) | (best.times < ends[0] * 1.001) | (best.times > ends[1] * 0.999)
    free = len(best.jacobian) - best.jacobian.shape[1]
    if free < 1:
        return np.full(2 * k, np.nan)
    used = np.concatenate([np.ones(tests, bool), best.strengths >= _AT_BOUND, ~bound])
    jacobian = best.jacobian[:, used]
    length = np.linalg.norm(jacobian, axis=0)
    inverse = np.linalg.pinv(jacobian / length)
    covariance = np.zeros((len(used), len(used)))
    covariance[np.ix_(used, used)] = best.objective / free * (inverse @ inverse.T) / np.outer(length, length)
    strengths = covariance[tests : tests + k, tests : tests + k]
    turn = (np.eye(k) - np.outer(best.strengths, np.ones(k)) / (1 + best.strengths.sum())) / np.maximum(
        best.strengths, 1e-12
    )[:, None]  # d log share_i / d strength_j
    deviation = np.sqrt(np.concatenate([np.diag(turn @ strengths @ turn.T), np.diag(covariance)[tests + k :]]))
    half = stdtrit(free, 0.5 + 0.5 * confidence) * deviation
    return np.asarray(np.where(np.concatenate([bound, bound]), np.nan, half))
