"""Fit of a ring to blobs, and its number of false alarms.

A ring is regularised towards its prediction, so that a few blobs cannot distort it. A blob that contradicts the
others is dropped. The significance of a ring is measured by an a-contrario test: the expected number of such rings
among as many random blobs (number of false alarms).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.special import gammaln

from palpate.core import BoolArray, FloatArray
from palpate.vision.ring_model import RingFit
from palpate.vision.rings import ring_harmonics
from palpate.vision.segment import MEDIAN_DISTANCE, MEDIAN_SD

_TRIED = 4
"""Number of radii and shifts of the next ring that are fitted. By hand."""
_LEAST_RADIUS_PX = 0.25
"""Minimum distance of a blob from its place in the number of false alarms. By hand."""
REACH = 0.3
"""Maximum distance of a blob from its place during the fit, over the distance of neighbours. By hand."""
PRINT_REACH, LEAST_REACH, LEAST_REACH_PX = 0.22, 0.15, 0.7
"""Bounds of this distance after the fit (the maximum also between places): maximum, minimum, in px.
By hand."""
STRAY = 4.5
"""Maximum distance of a blob from its place after the fit, in standard deviations. By hand."""
MARK_PX = 0.2
"""Minimum standard deviation of the orientation mark about its place. By hand."""
DOT_PX = 0.3
"""Standard deviation of a printed marker, px. By hand."""
_FLAT = 0.1
"""Standard deviation of the ratio of a ring's axes. By hand."""
_SMALL, DROP = 60, 3.0
"""Trial without each blob: maximum size of a ring, and gain that keeps a blob of the innermost ring.

The gain is in powers of ten of the number of false alarms. By hand.
"""
PREDICTED_REACH = 0.16
"""Maximum distance of a blob from its place in a ring predicted without it, over the spacing. By hand."""
_OFF, _SPENT = 6.0, 8.0
"""Trial in further rings: distance at which a blob is dropped, and degrees of freedom of the fit.

The distance is from the ring through the remaining blobs, in their standard deviations. By
hand.
"""


class RingPrior(NamedTuple):
    """Allowed deviation of a ring from its prediction, and its degrees of freedom in blobs."""

    centre_px: float
    harmonics: tuple[float, float, float]
    """Standard deviations of the first three harmonics, over the radius."""
    spent: float


ALONE = RingPrior(50.0, (1.0, 0.01, 0.002), 3.0)
"""Prior of the innermost ring, without a prediction."""
NEXT = RingPrior(4.0, (0.15, 0.03, 0.015), 3.0)
"""Prior of a ring predicted by the one inside."""
INSIDE = RingPrior(3.0, (0.08, 0.015, 0.005), 1.5)
"""Prior of a ring predicted by the one outside."""


class RingFitter:
    """Fitter of rings to blobs (n, 2)."""

    def __init__(self, blobs_px: FloatArray) -> None:
        self.blobs = blobs_px
        self.tree = cKDTree(blobs_px)
        self.density = len(blobs_px) / max(float(np.prod(np.ptp(blobs_px, axis=0))), 1.0)

    def scan(
        self,
        last: RingFit,
        phi: FloatArray,
        growths: FloatArray,
        shifts: FloatArray,
        taken: BoolArray,
        hold: RingPrior = NEXT,
    ) -> RingFit:
        """Return the fitted ring of the growth and shift that covers most blobs."""
        shape = ring_harmonics(phi, 7)[:, 1:] @ last.weights[1:]
        centre = last.weights[0] + shifts
        places = centre[None, :, None] + growths[:, None, None, None] * shape[None, None]
        distance, blob = self.tree.query(places)
        pitch = 2.0 * np.pi * growths * last.radius_px / len(phi)
        reach = (PRINT_REACH * pitch)[:, None, None]
        score = np.where((distance < reach) & ~taken[blob], 1.0 - (distance / reach) ** 2, 0.0).sum(axis=-1)
        tried, by_growth = [], score.max(axis=1)
        for _ in range(_TRIED):
            grown = int(np.argmax(by_growth))
            weights = np.vstack([centre[np.argmax(score[grown])], growths[grown] * last.weights[1:]])
            tried.append(self.fit(weights, taken, phi, hold))
            by_growth[max(grown - 1, 0) : grown + 2] = -1.0
        return min(tried, key=lambda ring: ring.power)

    def fit(self, weights: FloatArray, taken: BoolArray, phi: FloatArray, hold: RingPrior) -> RingFit:
        """Alternate between nearest blobs and ring fit, then drop blobs too far from the ring."""
        terms, held = ring_harmonics(phi, 7), weights
        blob = np.full(len(phi), -1)
        left, prior, settled = np.full(len(phi), np.nan), prior_rows(held, hold), False
        of = blob
        for again in range(6):
            if settled and again <= 3:  # the same ring reaches as far
                continue
            places = terms @ weights
            radius = max(float(np.linalg.svd(weights[1:3], compute_uv=False).mean()), 1.0)
            pitch = 2.0 * np.pi * radius / len(phi)
            reach = REACH * pitch
            if again > 3 and (blob >= 0).sum() > 3:
                spread = (
                    MEDIAN_SD
                    * np.nanmedian(left)
                    / MEDIAN_DISTANCE
                    * np.sqrt(max(len(phi) / max(len(phi) - 3, 1), 1.0))
                )
                reach = min(max(STRAY * spread, LEAST_REACH_PX, LEAST_REACH * pitch), PRINT_REACH * pitch)
            blob, left = self.nearest(places, reach, taken)
            have = blob >= 0
            if again == 5 or have.sum() < 3:
                break
            settled = np.array_equal(blob, of)  # the same blobs give the same ring
            if not settled:
                weights, of = self.fitted(terms[have], self.blobs[blob[have]], prior), blob
        if len(phi) <= _SMALL and (dropped := self._without_worst(terms, (held, hold), blob, left)):
            weights, blob, left = dropped
        if self._has_more(phi, weights):
            return RingFit(weights, np.full(len(phi), -1), np.full(len(phi), np.nan))
        return RingFit(weights, blob, left, self.power(blob, left, hold.spent) + _flatness(weights))

    def _without_worst(
        self,
        terms: FloatArray,
        held: tuple[FloatArray, RingPrior],
        blob: NDArray[np.intp],
        left: FloatArray,
    ) -> tuple[FloatArray, NDArray[np.intp], FloatArray] | None:
        """Return a small ring without a blob that distorts it; `None` if there is no such blob."""
        have = np.flatnonzero(blob >= 0)
        if len(have) < (4 if held[1] is INSIDE else 5):
            return None
        tried, prior = [], prior_rows(*held)
        for out in have:
            rest = have[have != out]
            fit = self.fitted(terms[rest], self.blobs[blob[rest]], prior)
            off = np.full(len(blob), np.nan)
            off[have] = np.linalg.norm(self.blobs[blob[have]] - terms[have] @ fit, axis=1)
            tried.append((off[out], fit, np.where(np.arange(len(blob)) == out, -1, blob), off))
        if held[1] is ALONE:
            power = [self.power(kept, off, held[1].spent) for _, _, kept, off in tried]
            which = int(np.argmin(power))
            drop = power[which] < self.power(blob, left, held[1].spent) + DROP
        else:
            which = int(np.argmax([each[0] for each in tried]))
            far, fit, kept, off = tried[which]
            spread = np.sqrt(np.sum(off[kept >= 0] ** 2) / max(2.0 * len(have) - 2.0 - _SPENT, 2.0))
            pitch = 2.0 * np.pi * float(np.linalg.svd(fit[1:3], compute_uv=False).mean()) / len(blob)
            drop = far > max(_OFF * spread, PREDICTED_REACH * pitch, LEAST_REACH_PX)
        if not drop:
            return None
        _, fit, kept, off = tried[which]
        away, dot = self.tree.query(terms[have[which]] @ fit)
        pitch = 2.0 * np.pi * float(np.linalg.svd(fit[1:3], compute_uv=False).mean()) / len(blob)
        if dot != blob[have[which]] and dot not in kept and away < max(PREDICTED_REACH * pitch, LEAST_REACH_PX):
            kept[have[which]], off[have[which]] = dot, away
        return fit, kept, np.where(kept >= 0, off, np.nan)

    def fitted(self, terms: FloatArray, seen: FloatArray, prior: tuple[FloatArray, FloatArray]) -> FloatArray:
        """Fit a ring to blobs (n, 2), regularised towards its prediction by `prior_rows`."""
        rows, right = prior
        return np.asarray(np.linalg.lstsq(np.vstack([terms, rows]), np.vstack([seen, right]), rcond=None)[0])

    def _has_more(self, phi: FloatArray, weights: FloatArray) -> bool:
        """Return whether there are blobs between the places too: a ring with two or three times as many."""
        for parts in (2, 3):
            step = 2.0 * np.pi / len(phi) / parts
            between = np.concatenate([phi + step * part for part in range(1, parts)])
            pitch = step * float(np.linalg.svd(weights[1:3], compute_uv=False).mean())
            distance = self.tree.query(ring_harmonics(between, 7) @ weights)[0]
            if np.mean(distance < REACH * pitch) > 0.5:
                return True
        return False

    def power(self, blob: NDArray[np.intp], left: FloatArray, free: float) -> float:
        """Return log10 of the number of false alarms of so many blobs so near to the places of a ring."""
        off, count = np.sort(left[blob >= 0]), len(blob)
        if not len(off):
            return 0.0
        one = np.minimum(self.density * np.pi * np.maximum(off, _LEAST_RADIUS_PX) ** 2, 1.0)
        kept = np.arange(1.0, len(off) + 1.0)
        ways = gammaln(count + 1) - gammaln(kept + 1) - gammaln(count - kept + 1)
        power = ways / np.log(10.0) + np.maximum(kept - free, 0.0) * np.log10(one)
        return float(min(power.min(), 0.0))

    def nearest(self, places: FloatArray, reach: float, taken: BoolArray) -> tuple[NDArray[np.intp], FloatArray]:
        """Return the free blob (n,) nearest to each place within reach, each blob once, and its distance."""
        distance, blob = self.tree.query(places)
        order = np.argsort(distance, kind="stable")
        first = np.zeros(len(places), bool)
        first[order[np.unique(blob[order], return_index=True)[1]]] = True
        good = first & (distance < reach) & ~taken[blob]
        return np.where(good, blob, -1), np.where(good, distance, np.nan)


def prior_rows(weights: FloatArray, hold: RingPrior) -> tuple[FloatArray, FloatArray]:
    """Return the rows of a least-squares fit, and their right sides, that hold a ring near its prediction."""
    radius = max(float(np.linalg.svd(weights[1:3], compute_uv=False).mean()), 1.0)
    sd = np.array([hold.centre_px, *(radius * each for each in hold.harmonics for _ in range(2))])
    ridge = DOT_PX / sd
    return np.diag(ridge), ridge[:, None] * weights


def _flatness(weights: FloatArray) -> float:
    """Return the penalty of an ellipse relative to a circle, in powers of ten."""
    axes = np.linalg.svd(weights[1:3], compute_uv=False)
    return float(0.5 * ((axes[0] / max(axes[1], 1e-9) - 1.0) / _FLAT) ** 2 / np.log(10.0))
