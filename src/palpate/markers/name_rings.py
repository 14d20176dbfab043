"""Rings of dots found by their structure: six about one, then twelve, then eighteen, whatever their radii.

A ring is known by its number of dots at even steps. Three dots that could be neighbours on the innermost ring give all
of it; each further ring is looked for outside the last one, over a range of radii, centres and growths, and accepted
where its number of dots closes around it. Nothing but the order of the rings, their numbers and their common azimuth is
taken from the design, so no law of the radii can mislead. What chance would give is counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, Delaunay, cKDTree
from scipy.special import gammaln

from palpate.core import FloatArray
from palpate.markers.pattern import MarkerPattern
from palpate.markers.ring_law import Profile, RingFit, learn_law
from palpate.markers.rings import Rings, waves

_NEAR = 8
"""Neighbours of a dot among which those beside it on the innermost ring are looked for."""
_SIDES, _BEND = (0.65, 1.55), (0.55, 1.75)
"""Bounds of the ratios of neighbouring chords, and of the diagonal to the radius, on the innermost ring."""
_AXES = 1.5
"""Greatest ratio of the axes of the innermost ring as three of its dots give it."""
_SIZES = (0.55, 1.8)
"""Bounds of its radius over the design's in the nominal image."""
_SEED = 0.3
"""How far a dot of the innermost ring may lie from where three others put it, over the radius."""
_LEAST_SEED, _POOR_SEED = 0.6, 0.55
"""Share of the dots of the innermost ring and its middle that a seed must have, and if none leads to all rings."""
_SEEDS = 40
"""Seeds that are tried at most, from the middle of the dots outwards."""
_LEAST_RING = 0.4
"""Share of a ring's dots that must be seen."""
_FULL_RING, _FULL = 0.75, 0.6
"""Shares of a ring, and of all, from which on nothing better is looked for,"""
_FEW = 3
"""if the rings are even and so few other dots are between."""
_GAPS = (0.35, 2.3)
"""Bounds of the distance to the next ring over what the last ring and the design's radii give."""
_TRIED = 4
"""Radii and shifts of the next ring that are looked at more closely."""
_NESTED = 0.7
"""Distance of the centres of two neighbouring rings over that of their radii, at which they all but touch."""
_WHOLE = 0.85
"""Share of the dots from which on half of the next is enough."""
_SURE = -80.0
"""Power of ten of the number of prints by chance below which a whole print is believed before others are looked at."""
_SCORE = 0.22
"""The reach while places are compared, over the distance of neighbours on the ring."""
_LEAST_RADIUS_PX = 0.25
"""A dot is not believed to lie nearer to its place than this, when chance is counted."""
_REACH = 0.3
"""How far from its place a dot of a ring may lie while the ring settles, over the least distance of its neighbours."""
_PRINT_REACH, _LEAST_REACH, _LEAST_REACH_PX = 0.22, 0.15, 0.7
"""The same once it has settled, at most and at least, and in px."""
_STRAY = 4.5
"""A dot this many standard deviations from its ring is not of it."""
_BESIDE = 0.3
"""Steps of a shifted ring, over the distance to the ring inside."""
_LAW_REACH = 0.16
"""How far dots may lie from a ring that is known by the law of others only, over the distance of neighbours."""
_PASSES = 3
_OUTSIDE, _FAR_PX = 0.35, 20.0
"""Steps of centre and turn in which the outermost ring is looked for, over the distance of its neighbours, and how far
from the middle of the dots, px."""
TWIST, _TWIST_POWER = 0.25, 20.0
"""Greatest turn of a ring against the one inside, over the step of its dots; and powers of ten that a whole step costs."""
_TELLING = 4
"""So many dots do not tell a ring's shape and whether they are its own."""
_GAPPY = 0.85
"""Share of its dots below which a ring is looked for again."""
_DOT_PX = 0.3
_SIZE = 0.15
"""Standard deviation of the innermost ring's size, as a share: print and camera together."""
_FLAT = 0.1
"""Standard deviation of the ratio of a ring's axes."""
_SMALL, _DROP = 60, 3.0
"""Rings of so many dots are tried without each. Of the innermost, one is dropped unless it makes chance less likely by
as many powers of ten;"""
_OFF, _OFF_PITCH, _SPENT = 6.0, 0.16, 8.0
"""of others, if it is so many standard deviations of the rest, and so far over the distance of neighbours, off the ring
of the rest, on which so many coordinates are spent."""
_MORE = 0.5
"""Share of the places between those of a ring at which it is another ring of more dots."""
_MIDDLE_MM, _MIDDLE_SD, _MIDDLE = 0.25, 4.5, 0.45
"""How far centres of rings scatter as one would say beforehand, mm; how many standard deviations the dot in the middle
may be off them, and how far at most over the innermost ring's radius."""


class _Hold(NamedTuple):
    """How far a ring may differ from its forecast, and how many dots its own freedom costs when chance is counted."""

    centre_px: float
    harmonics: tuple[float, float, float]
    """The first three, over the radius."""
    spent: float


_ALONE = _Hold(50.0, (1.0, 0.01, 0.002), 3.0)
"""The innermost ring, of which nothing is known."""
_NEXT = _Hold(4.0, (0.15, 0.03, 0.015), 3.0)
"""A ring as the one inside forecasts it."""
_INSIDE = _Hold(3.0, (0.08, 0.015, 0.005), 1.5)
"""A ring as the one outside forecasts it."""


@dataclass(frozen=True, eq=False)
class RingsFit:
    """The rings that were found from one seed, from the inside; the first is the dot in the middle."""

    rings: tuple[RingFit, ...]

    @property
    def count(self) -> int:
        """Number of dots."""
        return int(sum((ring.blob >= 0).sum() for ring in self.rings))

    @property
    def power(self) -> float:
        """Power of ten of the number of such prints among dots strewn at random, about one middle."""
        return float(sum(ring.power for ring in self.rings)) + _TWIST_POWER * float((self.twist**2).sum())

    @property
    def twist(self) -> FloatArray:
        """(k - 1,) how far each ring is turned against the one inside, over the step of its dots."""
        turns = np.array([ring.turn for ring in self.rings[1:]])
        steps = np.array([2.0 * np.pi / len(ring.blob) for ring in self.rings[2:]])
        return np.asarray(((np.diff(turns) + np.pi) % (2.0 * np.pi) - np.pi) / steps)

    @property
    def even(self) -> bool:
        """Whether all rings are, turned alike, and each within the next."""
        turned_alike = not (np.abs(self.twist) > TWIST).any()
        return turned_alike and not self.crossing and all(ring.even for ring in self.rings[1:])

    @property
    def crossing(self) -> int:
        """Number of the first ring that comes too near to the one inside; 0 where none does."""
        for number, (ring, outer) in enumerate(pairwise(self.rings[1:]), 2):
            aside = float(np.linalg.norm(outer.weights[0] - ring.weights[0]))
            if aside > _NESTED * (outer.radius_px - ring.radius_px):
                return number
        return 0

    @property
    def residual_px(self) -> float:
        """Root of the mean squared distance of the dots from their rings, the middle left out."""
        off = np.concatenate([ring.off_px[np.isfinite(ring.off_px)] for ring in self.rings[1:]])
        return float(np.sqrt(np.mean(off**2))) if len(off) else np.inf


class RingFinder:
    """Looks for the rings of a pattern among dots (n, 2)."""

    def __init__(self, blobs_px: FloatArray, pattern: MarkerPattern, rings: Rings) -> None:
        self.blobs, self.pattern, self.rings = blobs_px, pattern, rings
        self.tree = cKDTree(blobs_px)
        self.angles = [rings.azimuth[rings.members(k)] for k in range(len(rings) + 1)]
        nominal = [
            np.linalg.lstsq(waves(phi, 3), pattern.expected_px[rings.members(k)], rcond=None)[0]
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
        self.handed = float(np.sign(np.linalg.det(nominal[0][1:])))
        self.pixel = float(self.nominal_px[-1] / rings.rho[-1])
        self.seeds = 0
        self.density = len(blobs_px) / max(float(np.prod(np.ptp(blobs_px, axis=0))), 1.0)

    def find(self) -> list[RingsFit]:
        """The best fits first; of those about one middle, only the best."""
        found: list[RingsFit] = []
        for least in (_LEAST_SEED, _POOR_SEED) if len(self.rings) > 1 else (_LEAST_SEED,):
            if self._ask(self._seeds(least)[:_SEEDS], found):
                break
        else:
            found += self._from_outside() if len(self.rings) > 1 else []
        found.sort(key=lambda fit: fit.power)
        kept: list[RingsFit] = []
        for fit in found:
            middles = [other.rings[1].weights[0] for other in kept]
            near = 0.5 * fit.rings[1].radius_px
            if all(np.linalg.norm(fit.rings[1].weights[0] - middle) > near for middle in middles):
                kept.append(fit)
        if kept and len(self.rings) > 1 and len(kept[0].rings) == len(self.rings) + 1:
            kept[0] = self._finish(list(kept[0].rings[1:]))
        return kept

    def _ask(self, seeds: list[FloatArray], found: list[RingsFit]) -> bool:
        """Grow seeds one after the other, until a whole print is sure: then others of its middle only."""
        sure: RingsFit | None = None
        for weights in seeds:
            if sure and np.linalg.norm(weights[0] - sure.rings[1].weights[0]) > 0.5 * sure.rings[1].radius_px:
                continue
            fit = self._grow(weights)
            found.append(fit)
            every = fit.count >= _FULL * len(self.pattern) and len(fit.rings) == len(self.rings) + 1
            sure_of = _SURE if fit.count < _WHOLE * len(self.pattern) else _SURE / 2.0
            even = every and fit.power < sure_of and fit.even
            if even and self.strange(fit) <= _FEW + 0.03 * fit.count:
                sure = fit
        return sure is not None

    def _seeds(self, least: float) -> list[FloatArray]:
        """Innermost rings (7, 2) that three dots give and others confirm, those in the middle of the dots first."""
        blobs, phi = self.blobs, self.angles[1]
        step = 2.0 * np.pi / len(phi)
        near = self.tree.query(blobs, min(_NEAR + 1, len(blobs)))[1][:, 1:]
        a, c = np.triu_indices(near.shape[1], 1)
        first, last = np.concatenate([a, c]), np.concatenate([c, a])
        b = np.repeat(np.arange(len(blobs)), len(first))
        a, c = near[:, first].ravel(), near[:, last].ravel()
        # three neighbours on the ring, then the middle and two neighbours
        turn = np.array([-step, 0.0, step])
        side, other = blobs[a] - blobs[b], blobs[c] - blobs[b]
        lengths, others = np.linalg.norm(side, axis=1), np.linalg.norm(other, axis=1)
        across = side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0]
        alike = (lengths > _SIDES[0] * others) & (lengths < _SIDES[1] * others)
        keep = alike & (np.sign(across) == -self.handed) & (lengths > 1.0) & (others > 1.0)
        three = np.linalg.inv(waves(turn, 3)) @ np.stack([blobs[a], blobs[b], blobs[c]], axis=1)[keep]
        keep = alike & (np.sign(across) == self.handed) & (lengths > 1.0) & (others > 1.0)
        design = np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, np.cos(step), np.sin(step)]])
        two = np.linalg.inv(design) @ np.stack([blobs[b], blobs[a], blobs[c]], axis=1)[keep]
        weights = np.concatenate([three, two])
        axes = np.linalg.svd(weights[:, 1:], compute_uv=False)
        size = axes.mean(axis=1) / self.nominal_px[1]
        weights = weights[(axes[:, 0] < _AXES * axes[:, 1]) & (size > _SIZES[0]) & (size < _SIZES[1])]
        return self._confirmed(weights, least)

    def _confirmed(self, weights: FloatArray, least: float) -> list[FloatArray]:
        """Those of the seeds (n, 3, 2) that have dots enough, each set of dots once."""
        if not len(weights):
            return []
        radius = np.linalg.svd(weights[:, 1:], compute_uv=False).mean(axis=1)
        places = waves(self.angles[1], 3) @ weights
        places = np.concatenate([places, weights[:, :1]], axis=1)
        distance, blob = self.tree.query(places)
        hit = distance < _SEED * radius[:, None]
        enough = hit.sum(axis=1) >= least * places.shape[1]
        self.seeds = max(int(enough.sum()), self.seeds)
        middle = np.median(self.blobs, axis=0) / 2.0 + self.blobs.mean(axis=0) / 2.0
        far = np.linalg.norm(weights[:, 0] - middle, axis=1)
        misses = np.where(hit, distance, radius[:, None] * _SEED).sum(axis=1) / radius
        best: dict[frozenset[int], int] = {}
        for number in np.flatnonzero(enough)[np.argsort(misses[enough], kind="stable")]:
            best.setdefault(frozenset(blob[number][hit[number]].tolist()), int(number))
        order = sorted(best.values(), key=lambda number: (far[number] // (0.7 * radius[number]), misses[number]))
        return [np.vstack([weights[number], np.zeros((4, 2))]) for number in order]

    def _grow(self, weights: FloatArray) -> RingsFit:
        """All rings outwards from the innermost, as far as they are found; then the middle."""
        taken = np.zeros(len(self.blobs), bool)
        rings = [self._settle(weights, taken, self.angles[1], _ALONE)]
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
        """Rings that are all there, looked at again from their neighbours, and the middle."""
        for _ in range(_PASSES):
            before = [ring.blob for ring in rings]
            rings = self._look_again(rings)
            if all(np.array_equal(ring.blob, old) for ring, old in zip(rings, before, strict=True)):
                break
        rings = self._assign(self._mend(rings))
        return RingsFit((self._middle(rings, self._taken(rings)), *rings))

    def _from_outside(self) -> list[RingsFit]:
        """Prints found by their outermost ring, where too little is left of the innermost."""
        phi, design = self.angles[-1], self.nominal[-1]
        centre = np.median(self.blobs, axis=0) / 2.0 + self.blobs.mean(axis=0) / 2.0
        pitch = 2.0 * np.pi / len(phi)
        step = _OUTSIDE * pitch * self.nominal_px[-1]
        reach = np.arange(-_FAR_PX, _FAR_PX + step, step)
        grid = np.stack(np.meshgrid(reach, reach), axis=-1).reshape(-1, 2)
        nothing, free = np.full(len(phi), -1), np.zeros(len(self.blobs), bool)
        found = []
        for part in np.arange(0.0, 1.0, _OUTSIDE):
            start = RingFit(turned(np.vstack([centre, design[1:], np.zeros((4, 2))]), part * pitch), nothing, nothing * np.nan)
            found.append(self._scan(start, phi, np.arange(0.82, 1.2, 0.03), grid, free))
        outer = min(found, key=lambda ring: ring.power)
        fits = []
        for label in range(len(phi) // len(self.angles[1])):
            weights = turned(outer.weights, label * pitch)
            blob, left = self._nearest(waves(phi, 7) @ weights, _REACH * pitch * outer.radius_px, free)
            rings = []
            for number in range(1, len(self.angles) - 1):
                shrunk = weights * (self.nominal_px[number] / self.nominal_px[-1])
                shrunk[0] = weights[0]
                none = np.full(len(self.angles[number]), -1)
                rings.append(RingFit(shrunk, none, none * np.nan))
            fits.append(self._finish([*rings, replace(outer, weights=weights, blob=blob, off_px=left)]))
        return fits

    def _assign(self, rings: list[RingFit]) -> list[RingFit]:
        """All dots given to the places of all rings at once, each to the nearest."""
        for _ in range(2):
            places = [waves(phi, 7) @ ring.weights for phi, ring in zip(self.angles[1:], rings, strict=True)]
            every = cKDTree(np.concatenate(places))
            own = every.query(self.blobs)[1]
            first = 0
            for number, (ring, where) in enumerate(zip(rings, places, strict=True)):
                pitch = 2.0 * np.pi * ring.radius_px / len(where)
                distance, blob = self.tree.query(where)
                spread = _STRAY * ring.residual_px / np.sqrt(2.0) if ring.count else 0.0
                reach = min(max(spread, _LEAST_REACH * pitch, _LEAST_REACH_PX), _LAW_REACH * pitch)
                good = (distance < reach) & (own[blob] == first + np.arange(len(where)))
                first += len(where)
                blob, weights = np.where(good, blob, -1), ring.weights
                if good.sum() > len(where) / 2:
                    weights = self._fitted(
                        waves(self.angles[number + 1], 7)[good], self.blobs[blob[good]], weights, _NEXT
                    )
                rings[number] = replace(ring, weights=weights, blob=blob, off_px=np.where(good, distance, np.nan))
        return rings

    def _look_again(self, rings: list[RingFit]) -> list[RingFit]:
        """The innermost ring, and poor ones, as the ring outside (of the outermost, inside) says they should be."""
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
            gap = _BESIDE * (high - low) / 2.0
            grid = gap * np.stack(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]), axis=-1).reshape(-1, 2)
            new = self._scan(by, self.angles[number + 1], np.sort(radii) / by.radius_px, grid, taken, _INSIDE)
            if new.power < rings[number].power + (0.0 if number else _DROP):
                rings[number] = new
        return rings

    def _mend(self, rings: list[RingFit]) -> list[RingFit]:
        """Rings that are still too poor to tell their shape, as the law of the others says they should be."""
        good = [number for number, ring in enumerate(rings) if ring.even and ring.share > _LEAST_RING and ring.count > _TELLING]
        for number in set(range(len(rings))).difference(good) if len(good) > 1 else ():
            taken = self._taken([ring for other, ring in enumerate(rings) if other != number])
            rings[number] = self._by_law(number + 1, [rings[k] for k in good], [k + 1 for k in good], taken)
        return rings

    def _by_law(self, number: int, rings: list[RingFit], numbers: list[int], taken: NDArray[np.bool_]) -> RingFit:
        """A ring too poor to tell its own shape, as the law of others says, with the dots that lie there."""
        design = self.rings.rho[numbers]
        law = learn_law(rings, self.profile, self.nominal_px[numbers], design)
        rho = float(np.interp(self.rings.rho[number], design, law.rho / design) * self.rings.rho[number])
        like = rings[int(np.argmin(np.abs(np.array(numbers) - number)))]
        weights = like.weights * (law.zoom * rho * float(law.profile.scale(rho)) / like.radius_px)
        weights[0] = law.centre(rho)
        phi = self.angles[number]
        pitch = 2.0 * np.pi * like.radius_px / len(phi) * float(rho / law.rho.max())
        blob, left = self._nearest(waves(phi, 7) @ weights, _LAW_REACH * pitch, taken)
        return RingFit(weights, blob, left)

    def _middle(self, rings: list[RingFit], taken: NDArray[np.bool_]) -> RingFit:
        """The dot within the innermost ring."""
        law = learn_law(rings, self.profile, self.nominal_px[1:], self.rings.rho[1:])
        weights = np.vstack([law.centre(0.0), np.zeros((6, 2))])
        blob = np.full(len(self.angles[0]), -1)
        distance, dot = self.tree.query(weights[:1])
        reach = min(_MIDDLE_SD * law.centre_sd_px(_MIDDLE_MM * self.pixel), _MIDDLE * rings[0].radius_px)
        if len(blob) and distance[0] < reach and not taken[dot[0]]:
            blob[0] = dot[0]
            weights[0] = self.blobs[dot[0]]
        left = np.where(blob >= 0, distance, np.nan)
        return RingFit(weights, blob, left, self._power(blob, left, 0.0))

    def _next(self, rings: list[RingFit], taken: NDArray[np.bool_]) -> RingFit:
        """The ring outside the last one: the radius, and if need be the shift, under which it has most dots."""
        number, last = len(rings) + 1, rings[-1]
        return self._look(
            last, number, self.angles[number], self.nominal_px[number] / self.nominal_px[number - 1], taken
        )

    def strange(self, fit: RingsFit) -> int:
        """Number of dots within the outermost ring that are of none."""
        outer = waves(np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False), 7) @ fit.rings[-1].weights
        free = ~self._taken(fit.rings)
        hull = Delaunay(outer[ConvexHull(outer).vertices])
        return int((hull.find_simplex(self.blobs[free]) >= 0).sum())

    def _taken(self, rings: Sequence[RingFit]) -> NDArray[np.bool_]:
        """(n,) whether a dot is of a ring."""
        taken = np.zeros(len(self.blobs), bool)
        for ring in rings:
            taken[ring.blob[ring.blob >= 0]] = True
        return taken

    def beyond(self, fit: RingsFit) -> tuple[int, int]:
        """How many dots one more ring than the design's would have, and how many of them are there."""
        taken = self._taken(fit.rings)
        counts = [len(phi) for phi in self.angles]
        more = 2 * counts[-1] - counts[-2] if len(counts) > 2 else 2 * counts[-1]
        phi = self.angles[-1][0] + 2.0 * np.pi * np.arange(more) / more
        inside = self.nominal_px[-1] - self.nominal_px[-2]
        ring = self._look(fit.rings[-1], len(counts), phi, 1.0 + inside / self.nominal_px[-1], taken)
        return more, int((ring.blob >= 0).sum())

    def _look(self, last: RingFit, number: int, phi: FloatArray, growth: float, taken: NDArray[np.bool_]) -> RingFit:
        radius = last.radius_px
        gap, pitch = (growth - 1.0) * radius, 2.0 * np.pi * growth * radius / len(phi)
        step = 0.3 * min(gap, pitch)
        radii = np.arange(radius + _GAPS[0] * gap, radius + _GAPS[1] * gap + step, step)
        best = self._scan(last, phi, radii / radius, np.zeros((1, 2)), taken)
        if best.share < _FULL_RING:
            grid = _BESIDE * gap * np.stack(np.meshgrid([-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]), axis=-1).reshape(-1, 2)
            other = self._scan(last, phi, radii / radius, grid, taken)
            best = min(best, other, key=lambda ring: ring.power)
        return best

    def _scan(
        self,
        last: RingFit,
        phi: FloatArray,
        growths: FloatArray,
        shifts: FloatArray,
        taken: NDArray[np.bool_],
        hold: _Hold = _NEXT,
    ) -> RingFit:
        """The ring of the growth and shift under which most dots are on it."""
        shape = waves(phi, 7)[:, 1:] @ last.weights[1:]
        centre = last.weights[0] + shifts
        places = centre[None, :, None] + growths[:, None, None, None] * shape[None, None]
        distance, blob = self.tree.query(places)
        pitch = 2.0 * np.pi * growths * last.radius_px / len(phi)
        reach = (_SCORE * pitch)[:, None, None]
        score = np.where((distance < reach) & ~taken[blob], 1.0 - (distance / reach) ** 2, 0.0).sum(axis=-1)
        tried, by_growth = [], score.max(axis=1)
        for _ in range(_TRIED):
            grown = int(np.argmax(by_growth))
            weights = np.vstack([centre[np.argmax(score[grown])], growths[grown] * last.weights[1:]])
            tried.append(self._settle(weights, taken, phi, hold))
            by_growth[max(grown - 1, 0) : grown + 2] = -1.0
        return min(tried, key=lambda ring: ring.power)

    def _settle(self, weights: FloatArray, taken: NDArray[np.bool_], phi: FloatArray, hold: _Hold) -> RingFit:
        """Nearest dots and the ring in turn; at last what is too far from it is left out."""
        terms, held = waves(phi, 7), weights
        blob = np.full(len(phi), -1)
        left = np.full(len(phi), np.nan)
        for again in range(6):
            places = terms @ weights
            radius = max(float(np.linalg.svd(weights[1:3], compute_uv=False).mean()), 1.0)
            pitch = 2.0 * np.pi * radius / len(phi)
            reach = _REACH * pitch
            if again > 3 and (blob >= 0).sum() > 3:
                spread = 1.4826 * np.nanmedian(left) / 1.1774 * np.sqrt(max(len(phi) / max(len(phi) - 3, 1), 1.0))
                reach = min(max(_STRAY * spread, _LEAST_REACH_PX, _LEAST_REACH * pitch), _PRINT_REACH * pitch)
            blob, left = self._nearest(places, reach, taken)
            have = blob >= 0
            if again == 5 or have.sum() < 3:
                break
            weights = self._fitted(terms[have], self.blobs[blob[have]], held, hold)
        if len(phi) <= _SMALL:
            if dropped := self._without_worst(terms, (held, hold), blob, left):
                weights, blob, left = dropped
        if self._has_more(phi, weights):
            return RingFit(weights, np.full(len(phi), -1), np.full(len(phi), np.nan))
        return RingFit(weights, blob, left, self._power(blob, left, hold.spent) + _flatness(weights))

    def _without_worst(
        self,
        terms: FloatArray,
        held: tuple[FloatArray, _Hold],
        blob: NDArray[np.intp],
        left: FloatArray,
    ) -> tuple[FloatArray, NDArray[np.intp], FloatArray] | None:
        """A small ring without a dot that alone bends it: the others then fit so well that chance does it less."""
        have = np.flatnonzero(blob >= 0)
        if len(have) < 5:
            return None
        tried = []
        for out in have:
            rest = have[have != out]
            fit = self._fitted(terms[rest], self.blobs[blob[rest]], *held)
            off = np.full(len(blob), np.nan)
            off[have] = np.linalg.norm(self.blobs[blob[have]] - terms[have] @ fit, axis=1)
            tried.append((off[out], fit, np.where(np.arange(len(blob)) == out, -1, blob), off))
        if held[1] is _ALONE:
            power = [self._power(kept, off, held[1].spent) for _, _, kept, off in tried]
            which = int(np.argmin(power))
            drop = power[which] < self._power(blob, left, held[1].spent) + _DROP
        else:
            which = int(np.argmax([each[0] for each in tried]))
            far, fit, kept, off = tried[which]
            spread = np.sqrt(np.sum(off[kept >= 0] ** 2) / max(2.0 * len(have) - 2.0 - _SPENT, 2.0))
            pitch = 2.0 * np.pi * float(np.linalg.svd(fit[1:3], compute_uv=False).mean()) / len(blob)
            drop = far > max(_OFF * spread, _OFF_PITCH * pitch, _LEAST_REACH_PX)
        if not drop:
            return None
        _, fit, kept, off = tried[which]
        away, dot = self.tree.query(terms[have[which]] @ fit)
        pitch = 2.0 * np.pi * float(np.linalg.svd(fit[1:3], compute_uv=False).mean()) / len(blob)
        if dot != blob[have[which]] and dot not in kept and away < max(_OFF_PITCH * pitch, _LEAST_REACH_PX):
            kept[have[which]], off[have[which]] = dot, away
        return fit, kept, np.where(kept >= 0, off, np.nan)

    def _fitted(self, terms: FloatArray, seen: FloatArray, weights: FloatArray, hold: _Hold) -> FloatArray:
        """The ring through dots (n, 2), as near to its forecast as it is held."""
        radius = max(float(np.linalg.svd(weights[1:3], compute_uv=False).mean()), 1.0)
        sd = np.array([hold.centre_px, *(radius * each for each in hold.harmonics for _ in range(2))])
        ridge = _DOT_PX / sd
        rows = np.vstack([terms, np.diag(ridge)])
        return np.asarray(np.linalg.lstsq(rows, np.vstack([seen, ridge[:, None] * weights]), rcond=None)[0])

    def _has_more(self, phi: FloatArray, weights: FloatArray) -> bool:
        """Whether there are dots between the places too, at halves or thirds: a ring of twice or thrice as many."""
        for parts in (2, 3):
            step = 2.0 * np.pi / len(phi) / parts
            between = np.concatenate([phi + step * part for part in range(1, parts)])
            pitch = step * float(np.linalg.svd(weights[1:3], compute_uv=False).mean())
            distance = self.tree.query(waves(between, 7) @ weights)[0]
            if np.mean(distance < _REACH * pitch) > _MORE:
                return True
        return False

    def _power(self, blob: NDArray[np.intp], left: FloatArray, free: float) -> float:
        """Power of ten of how often chance puts so many dots so near to the places of a ring."""
        off, count = np.sort(left[blob >= 0]), len(blob)
        if not len(off):
            return 0.0
        one = np.minimum(self.density * np.pi * np.maximum(off, _LEAST_RADIUS_PX) ** 2, 1.0)
        kept = np.arange(1.0, len(off) + 1.0)
        ways = gammaln(count + 1) - gammaln(kept + 1) - gammaln(count - kept + 1)
        power = ways / np.log(10.0) + np.maximum(kept - free, 0.0) * np.log10(one)
        return float(min(power.min(), 0.0))

    def _nearest(
        self, places: FloatArray, reach: float, taken: NDArray[np.bool_]
    ) -> tuple[NDArray[np.intp], FloatArray]:
        """(n,) the free dot of each place within reach, each dot once, and its distance."""
        distance, blob = self.tree.query(places)
        order = np.argsort(distance, kind="stable")
        first = np.zeros(len(places), bool)
        first[order[np.unique(blob[order], return_index=True)[1]]] = True
        good = first & (distance < reach) & ~taken[blob]
        return np.where(good, blob, -1), np.where(good, distance, np.nan)


def _flatness(weights: FloatArray) -> float:
    """Powers of ten by which an ellipse is less likely than a circle."""
    axes = np.linalg.svd(weights[1:3], compute_uv=False)
    return float(0.5 * ((axes[0] / max(axes[1], 1e-9) - 1.0) / _FLAT) ** 2 / np.log(10.0))


def turned(weights: FloatArray, angle: float) -> FloatArray:
    """Factors (7, 2) of a ring whose azimuths are counted from `angle`."""
    found = weights.copy()
    for order in range(1, len(weights) // 2 + 1):
        a, b = weights[2 * order - 1], weights[2 * order]
        c, s = np.cos(order * angle), np.sin(order * angle)
        found[2 * order - 1 : 2 * order + 1] = c * a + s * b, c * b - s * a
    return found


def _mark_radius(pattern: MarkerPattern) -> float:
    """Distance of the orientation mark from the axis of the nominal image, px; 0 without a mark."""
    if pattern.marks_px is None or pattern.mark is None:
        return 0.0
    return float(np.linalg.svd(np.linalg.lstsq(waves(mark_turns(pattern), 3), pattern.marks_px, rcond=None)[0][1:],
                               compute_uv=False).mean())  # fmt: skip


def mark_turns(pattern: MarkerPattern) -> FloatArray:
    """(g,) azimuth of the orientation mark under each symmetry."""
    azimuth = 0.0 if pattern.mark is None else np.arctan2(pattern.mark[1], pattern.mark[0])
    return np.asarray(np.radians(pattern.turns_deg) + np.where(pattern.mirrored, -azimuth, azimuth))
