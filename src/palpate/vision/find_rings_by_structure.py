"""Rings of markers found by their structure: six around one, then twelve, then eighteen, at any radii.

A ring is defined by its number of evenly spaced blobs. Three blobs that could be neighbours on the innermost ring
determine it. Each further ring is searched outside the last one, over a range of radii and centres, and accepted if
its number of blobs closes around it. Then every poor ring is searched again, as predicted by its neighbours. Only the
order of the rings, their numbers and their common azimuth are taken from the design, not their radii.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, cKDTree

from palpate.core import BoolArray, FloatArray
from palpate.vision.fit_ring import (
    ALONE,
    DROP,
    INSIDE,
    LEAST_REACH,
    LEAST_REACH_PX,
    NEXT,
    PREDICTED_REACH,
    REACH,
    STRAY,
    RingFitter,
    prior_rows,
)
from palpate.vision.pattern import MarkerPattern
from palpate.vision.ring_model import Profile, RingFit, RingsFit, fit_ring_model
from palpate.vision.ring_seeds import seed_rings
from palpate.vision.rings import Rings, ring_harmonics

_LEAST_SEED, _POOR_SEED = 0.6, 0.55
"""Minimum share of the innermost ring and its centre for a seed, in two attempts. By hand."""
_SEEDS = 40
"""Maximum number of seeds, from the centre of the blobs outwards. By hand."""
_LEAST_RING = 0.4
"""Minimum share of a ring's blobs that must be found. By hand."""
_FULL_RING, _FULL = 0.75, 0.6
"""Shares of a ring, and of all, at which the search ends, By hand."""
_FEW = 3
"""if the rings are even and contain no more than so many other blobs. By hand."""
_GAPS = (0.35, 2.3)
"""Bounds of the distance to the next ring, over that given by the last ring and the design's radii.
By hand."""
_WHOLE = 0.85
"""Share of the blobs above which half of `_SURE` suffices. By hand."""
_SURE = -80.0
"""Log10 of the number of false alarms below which a print is accepted without alternatives. By hand."""
_NEIGHBOURS = 0.3
"""Steps of a shifted ring, over the distance to the ring inside. By hand."""
_PASSES = 3
"""Passes over poor rings. By hand."""
_OUTSIDE, _FAR_PX = 0.35, 20.0
"""Search of the outermost ring: steps of centre and rotation, and range of its centre.

The steps are over the distance of its neighbours, the range is from the centre of the blobs, px. By hand.
"""
_FEW_DOTS, _TEMPTING, _AGREED = 4, 0.6, 0.05
"""Limits of an unreliable ring: maximum number of blobs, distance of a false blob, centre offset.

A ring of so few blobs is unreliable if a false blob is nearer than this to an empty place (over the spacing on the
ring), unless its centre is nearer than this to that of the next ring. By hand.
"""
_LOPSIDED, _INNERMOST = 0.25, 6
"""Limits of a distorted ring: distance of a blob, and maximum number of blobs.

The distance is that from an ellipse through the remaining blobs, over the spacing on the ring. Rings of more than
`_FEW_DOTS` and at most this number of blobs are tested. By hand.
"""
_TELLING = 3
"""Maximum number of blobs that cannot determine both a ring's shape and membership. By hand."""
_GAPPY = 0.85
"""Share of its blobs below which a ring is searched again. By hand."""
_SIZE = 0.15
"""Relative standard deviation of the innermost ring's size, by print and camera. By hand."""
_MIDDLE_MM, _MIDDLE = 0.25, 0.45
"""Centre marker: prior scatter of ring centres, mm, and maximum distance.

The distance is over the radius of the innermost ring, and below `STRAY` standard deviations. By hand.
"""


class RingFinder:
    """Search of the rings of a pattern among blobs (n, 2)."""

    def __init__(self, blobs_px: FloatArray, pattern: MarkerPattern, rings: Rings) -> None:
        self.blobs, self.pattern, self.rings = blobs_px, pattern, rings
        self.settler = RingFitter(blobs_px)
        self.angles = [rings.azimuth[rings.members(k)] for k in range(len(rings) + 1)]
        nominal = [
            np.linalg.lstsq(ring_harmonics(phi, 3), pattern.expected_px[rings.members(k)], rcond=None)[0]
            for k, phi in enumerate(self.angles)
            if k
        ]
        self.nominal = nominal
        self.nominal_px = np.array([0.0, *(np.linalg.svd(w[1:], compute_uv=False).mean() for w in nominal)])
        self.mark_px = _mark_radius(pattern)
        known = np.column_stack([rings.rho, rings.height, self.nominal_px])[1:]
        if pattern.mark is not None:
            known = np.vstack([known, [np.hypot(*pattern.mark[:2]), pattern.mark[2], self.mark_px]])
        self.profile = Profile(*known.T)
        self.pixel = float(self.nominal_px[-1] / rings.rho[-1])
        self.seeds = 0
        self.other: RingsFit | None = None

    def find(self) -> list[RingsFit]:
        """Return the fits, best first; of those with a common centre, only the best."""
        found: list[RingsFit] = []
        for least in (_LEAST_SEED, _POOR_SEED) if len(self.rings) > 1 else (_LEAST_SEED,):
            seeds, number = seed_rings(self.settler, self.angles[1], np.asarray(self.nominal[0], float), least)
            self.seeds = max(self.seeds, number)
            if self._ask(seeds[:_SEEDS], found):
                break
        else:
            found += self._from_outside() if len(self.rings) > 1 else []
        found.sort(key=lambda fit: fit.power)
        self.other = next((fit for fit in found[1:] if _of_others(fit, found[0])), None)
        chosen: list[RingsFit] = []
        for fit in found:
            middles = [other.rings[1].weights[0] for other in chosen]
            near = 0.5 * fit.rings[1].radius_px
            if all(np.linalg.norm(fit.rings[1].weights[0] - middle) > near for middle in middles):
                chosen.append(fit)
        if chosen and len(self.rings) > 1 and len(chosen[0].rings) == len(self.rings) + 1:
            chosen[0] = self._finish(list(chosen[0].rings[1:]))
        return chosen

    def _ask(self, seeds: list[FloatArray], found: list[RingsFit]) -> bool:
        """Grow seeds one by one; once a complete print is certain, only seeds near its centre."""
        sure: RingsFit | None = None
        for weights in seeds:
            if sure and np.linalg.norm(weights[0] - sure.rings[1].weights[0]) > 0.5 * sure.rings[1].radius_px:
                continue
            fit = self._grow(weights)
            found.append(fit)
            every = fit.count >= _FULL * len(self.pattern) and len(fit.rings) == len(self.rings) + 1
            sure_of = _SURE if fit.count < _WHOLE * len(self.pattern) else _SURE / 2.0
            even = every and fit.power < sure_of and fit.even
            if even and self.count_unassigned(fit) <= _FEW + 0.03 * fit.count:
                sure = fit
        return sure is not None

    def _grow(self, weights: FloatArray) -> RingsFit:
        """Grow all rings outwards from the innermost one, as far as they are found, then the centre marker."""
        taken = np.zeros(len(self.blobs), bool)
        rings = [self.settler.fit(weights, taken, self.angles[1], ALONE)]
        size = float(np.log(rings[0].radius_px / self.nominal_px[1]) / _SIZE)
        rings[0] = replace(rings[0], power=rings[0].power + 0.5 * size**2 / np.log(10.0))
        while rings[-1].share >= _LEAST_RING:
            taken[rings[-1].blob[rings[-1].blob >= 0]] = True
            if len(rings) == len(self.rings):
                break
            rings.append(self._next(rings, taken))
        if rings[-1].share < _LEAST_RING and len(rings) > 1:
            rings.pop()
        if len(rings) == len(self.rings):
            return self._finish(rings)
        return RingsFit((self._middle(rings, taken), *rings))

    def _finish(self, rings: list[RingFit]) -> RingsFit:
        """Refine a complete set of rings from their neighbours, and find the centre marker."""
        for _ in range(_PASSES):
            before = [ring.blob for ring in rings]
            rings = self._look_again(rings)
            if all(np.array_equal(ring.blob, old) for ring, old in zip(rings, before, strict=True)):
                break
        rings = self._assign(self._mend(rings))
        return RingsFit((self._middle(rings, self._taken(rings)), *rings))

    def _from_outside(self) -> list[RingsFit]:
        """Find prints by their outermost ring, if too little is left of the innermost."""
        phi, design = self.angles[-1], self.nominal[-1]
        centre = np.median(self.blobs, axis=0) / 2.0 + self.blobs.mean(axis=0) / 2.0
        pitch = 2.0 * np.pi / len(phi)
        step = _OUTSIDE * pitch * self.nominal_px[-1]
        reach = np.arange(-_FAR_PX, _FAR_PX + step, step)
        grid = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2)
        nothing, free = np.full(len(phi), -1), np.zeros(len(self.blobs), bool)
        found = []
        for part in np.arange(0.0, 1.0, _OUTSIDE):
            start = RingFit(
                turned(np.vstack([centre, design[1:], np.zeros((4, 2))]), part * pitch), nothing, nothing * np.nan
            )
            found.append(self.settler.scan(start, phi, np.arange(0.82, 1.2, 0.03), grid, free))
        outer = min(found, key=lambda ring: ring.power)
        fits = []
        for label in range(len(phi) // len(self.angles[1])):
            weights = turned(outer.weights, label * pitch)
            blob, left = self.settler.nearest(ring_harmonics(phi, 7) @ weights, REACH * pitch * outer.radius_px, free)
            rings = []
            for number in range(1, len(self.angles) - 1):
                shrunk = weights * (self.nominal_px[number] / self.nominal_px[-1])
                shrunk[0] = weights[0]
                none = np.full(len(self.angles[number]), -1)
                rings.append(RingFit(shrunk, none, none * np.nan))
            fits.append(self._finish([*rings, replace(outer, weights=weights, blob=blob, error_px=left)]))
        return fits

    def _assign(self, rings: list[RingFit]) -> list[RingFit]:
        """Assign all blobs to the places of all rings at once, each to the nearest."""
        for _ in range(2):
            places = [ring_harmonics(phi, 7) @ ring.weights for phi, ring in zip(self.angles[1:], rings, strict=True)]
            every = cKDTree(np.concatenate(places))
            own = every.query(self.blobs)[1]
            first = 0
            for number, (ring, where) in enumerate(zip(rings, places, strict=True)):
                pitch = 2.0 * np.pi * ring.radius_px / len(where)
                distance, blob = self.settler.tree.query(where)
                spread = STRAY * ring.residual_px / np.sqrt(2.0) if ring.count else 0.0
                reach = min(max(spread, LEAST_REACH * pitch, LEAST_REACH_PX), PREDICTED_REACH * pitch)
                good = (distance < reach) & (own[blob] == first + np.arange(len(where)))
                first += len(where)
                blob, weights = np.where(good, blob, -1), ring.weights
                if good.sum() > len(where) / 2:
                    terms = ring_harmonics(self.angles[number + 1], 7)[good]
                    weights = self.settler.fitted(terms, self.blobs[blob[good]], prior_rows(weights, NEXT))
                rings[number] = replace(ring, weights=weights, blob=blob, error_px=np.where(good, distance, np.nan))
        return rings

    def _look_again(self, rings: list[RingFit]) -> list[RingFit]:
        """Search the innermost ring and poor rings again, as predicted by the next outer (else inner) ring."""
        for number in reversed(range(len(rings) if len(rings) > 1 else 0)):
            if number and rings[number].share > _GAPPY and rings[number].even:
                continue
            by = rings[number + 1] if number + 1 < len(rings) else rings[number - 1]
            low = rings[number - 1].radius_px if number else 0.5 * rings[0].radius_px
            high = rings[number + 1].radius_px if number + 1 < len(rings) else 1.3 * rings[number].radius_px
            radii = np.append(np.arange(low + 0.15 * (high - low), high - 0.1 * (high - low), 0.06 * (high - low)),
                              rings[number].radius_px)  # fmt: skip
            whole = [ring for ring in rings[:number] if ring.even and ring.share > _FULL_RING]
            taken = self._taken([*whole, *rings[number + 1 :]])
            gap = _NEIGHBOURS * (high - low) / 2.0
            grid = gap * np.stack(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]), axis=-1).reshape(-1, 2)
            new = self.settler.scan(by, self.angles[number + 1], np.sort(radii) / by.radius_px, grid, taken, INSIDE)
            if new.power < rings[number].power + (0.0 if number else DROP):
                rings[number] = new
        return rings

    def _mend(self, rings: list[RingFit]) -> list[RingFit]:
        """Replace rings too poor to determine their shape by the prediction of the ring model."""
        good = [
            number
            for number, ring in enumerate(rings)
            if ring.even and ring.share > _LEAST_RING and ring.count > _TELLING
        ]
        for number in set(range(len(rings))).difference(good) if len(good) > 1 else ():
            taken = self._taken([ring for other, ring in enumerate(rings) if other != number])
            rings[number] = self._by_law(number + 1, [rings[k] for k in good], [k + 1 for k in good], taken)
        return rings

    def _by_law(self, number: int, rings: list[RingFit], numbers: list[int], taken: BoolArray) -> RingFit:
        """Predict a poor ring by the model of the good ones, and assign the blobs near it."""
        design = self.rings.rho[numbers]
        law = fit_ring_model(rings, self.profile, self.nominal_px[numbers], design)
        rho = float(np.interp(self.rings.rho[number], design, law.rho / design) * self.rings.rho[number])
        like = rings[int(np.argmin(np.abs(np.array(numbers) - number)))]
        weights = like.weights * (law.zoom * rho * float(law.profile.scale(rho)) / like.radius_px)
        weights[0] = law.centre(rho)
        phi = self.angles[number]
        pitch = 2.0 * np.pi * like.radius_px / len(phi) * float(rho / law.rho.max())
        terms = ring_harmonics(phi, 7)
        prior = prior_rows(weights, INSIDE)
        for _ in range(3):
            blob, left = self.settler.nearest(terms @ weights, PREDICTED_REACH * pitch, taken)
            have = blob >= 0
            if not have.any():
                break
            weights = self.settler.fitted(terms[have], self.blobs[blob[have]], prior)
        return RingFit(weights, blob, left)

    def _middle(self, rings: list[RingFit], taken: BoolArray) -> RingFit:
        """Find the centre marker, inside the innermost ring."""
        law = fit_ring_model(rings, self.profile, self.nominal_px[1:], self.rings.rho[1:])
        weights = np.vstack([law.centre(0.0), np.zeros((6, 2))])
        blob = np.full(len(self.angles[0]), -1)
        distance, dot = self.settler.tree.query(weights[:1])
        reach = min(STRAY * law.centre_sd_px(_MIDDLE_MM * self.pixel), _MIDDLE * rings[0].radius_px)
        if len(blob) and distance[0] < reach and not taken[dot[0]]:
            blob[0] = dot[0]
            weights[0] = self.blobs[dot[0]]
        left = np.where(blob >= 0, distance, np.nan)
        return RingFit(weights, blob, left, self.settler.power(blob, left, 0.0))

    def _next(self, rings: list[RingFit], taken: BoolArray) -> RingFit:
        """Find the next outer ring: the radius, and if necessary the shift, with the most blobs."""
        number, last = len(rings) + 1, rings[-1]
        return self._look(
            last, number, self.angles[number], self.nominal_px[number] / self.nominal_px[number - 1], taken
        )

    def first_unreliable_ring(self, fit: RingsFit) -> int:
        """Return the first ring with so few blobs that a nearby false one could distort it, or 0."""
        free = self.blobs[~self._taken(fit.rings)]
        rings = fit.rings[1:] if len(free) else ()
        for number, ring in enumerate(rings, 1):
            beside = rings[number if number < len(rings) else number - 2]
            aside = float(np.linalg.norm(ring.weights[0] - beside.weights[0]))
            if ring.count > _FEW_DOTS or aside < _AGREED * 2.0 * np.pi * ring.radius_px / len(ring.blob):
                continue
            places = ring_harmonics(self.angles[number], 7)[ring.blob < 0] @ ring.weights
            pitch = 2.0 * np.pi * ring.radius_px / len(ring.blob)
            if ring.count and cKDTree(free).query(places)[0].min() < _TEMPTING * pitch:
                return number
        return 0

    def first_distorted_ring(self, fit: RingsFit) -> int:
        """Return the first ring of few blobs one of which is far from the ellipse of the remaining ones, or 0."""
        for number, ring in enumerate(fit.rings[1:], 1):
            there = np.flatnonzero(ring.blob >= 0)
            if not _FEW_DOTS < len(there) <= _INNERMOST:
                continue
            terms, seen = ring_harmonics(self.angles[number][there], 3), self.blobs[ring.blob[there]]
            hat = terms @ np.linalg.pinv(terms)
            left = (seen - hat @ seen) / (1.0 - np.diag(hat))[:, None]
            if np.linalg.norm(left, axis=1).max() > _LOPSIDED * 2.0 * np.pi * ring.radius_px / len(ring.blob):
                return number
        return 0

    def count_unassigned(self, fit: RingsFit) -> int:
        """Return the number of unassigned blobs inside the outermost ring."""
        outer = ring_harmonics(np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False), 7) @ fit.rings[-1].weights
        free = ~self._taken(fit.rings)
        hull = Delaunay(outer[ConvexHull(outer).vertices])
        return int((hull.find_simplex(self.blobs[free]) >= 0).sum())

    def _taken(self, rings: Sequence[RingFit]) -> BoolArray:
        """Return whether each blob (n,) belongs to a ring."""
        taken = np.zeros(len(self.blobs), bool)
        for ring in rings:
            taken[ring.blob[ring.blob >= 0]] = True
        return taken

    def beyond(self, fit: RingsFit) -> tuple[int, int]:
        """Return the number of markers of one ring more than in the design, and the number of its blobs found."""
        taken = self._taken(fit.rings)
        counts = [len(phi) for phi in self.angles]
        more = 2 * counts[-1] - counts[-2] if len(counts) > 2 else 2 * counts[-1]
        phi = self.angles[-1][0] + 2.0 * np.pi * np.arange(more) / more
        inside = self.nominal_px[-1] - self.nominal_px[-2]
        ring = self._look(fit.rings[-1], len(counts), phi, 1.0 + inside / self.nominal_px[-1], taken)
        return more, int((ring.blob >= 0).sum())

    def _look(self, last: RingFit, number: int, phi: FloatArray, growth: float, taken: BoolArray) -> RingFit:
        radius = last.radius_px
        gap, pitch = (growth - 1.0) * radius, 2.0 * np.pi * growth * radius / len(phi)
        step = 0.3 * min(gap, pitch)
        radii = np.arange(radius + _GAPS[0] * gap, radius + _GAPS[1] * gap + step, step)
        best = self.settler.scan(last, phi, radii / radius, np.zeros((1, 2)), taken)
        if best.share < _FULL_RING:
            grid = (
                _NEIGHBOURS * gap * np.stack(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]), axis=-1).reshape(-1, 2)
            )
            other = self.settler.scan(last, phi, radii / radius, grid, taken)
            best = min(best, other, key=lambda ring: ring.power)
        return best


def _of_others(fit: RingsFit, best: RingsFit) -> bool:
    """Return whether a fit has as many blobs as the best, and other ones."""
    return fit.count >= best.count and set(fit.rings[-1].blob.tolist()) != set(best.rings[-1].blob.tolist())


def turned(weights: FloatArray, angle: float) -> FloatArray:
    """Return the weights (7, 2) of a ring with azimuths counted from `angle`."""
    found = weights.copy()
    for order in range(1, len(weights) // 2 + 1):
        a, b = weights[2 * order - 1], weights[2 * order]
        c, s = np.cos(order * angle), np.sin(order * angle)
        found[2 * order - 1 : 2 * order + 1] = c * a + s * b, c * b - s * a
    return found


def _mark_radius(pattern: MarkerPattern) -> float:
    """Return the distance of the orientation mark from the axis in the nominal image, px; 0 without it."""
    if pattern.marks_px is None or pattern.mark is None:
        return 0.0
    waves = ring_harmonics(mark_turns(pattern), 3)
    fitted = np.linalg.lstsq(waves, pattern.marks_px, rcond=None)[0][1:]
    return float(np.linalg.svd(fitted, compute_uv=False).mean())


def mark_turns(pattern: MarkerPattern) -> FloatArray:
    """Return the azimuth (g,) of the orientation mark under each symmetry."""
    azimuth = 0.0 if pattern.mark is None else np.arctan2(pattern.mark[1], pattern.mark[0])
    return np.asarray(np.radians(pattern.turns_deg) + np.where(pattern.mirrored, -azimuth, azimuth))
