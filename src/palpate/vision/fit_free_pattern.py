"""Fit of a free layout to blobs: patches of neighbouring markers, grown to whole assignments.

A patch of neighbouring markers is placed on every blob, rotated and scaled. From the placements that cover most
blobs, an assignment is grown (`palpate.vision.grow_assignment`). A smooth map is fitted to it and determines the
final assignment, so any smooth distortion of the print is allowed. If another placement explains as many markers, the
assignment is doubtful.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.spatial import ConvexHull, Delaunay, cKDTree
from scipy.stats import binom

from palpate.core import FloatArray, IntArray
from palpate.vision.fit_ring import LEAST_REACH_PX, MARK_PX, PRINT_REACH, REACH, STRAY
from palpate.vision.grow_assignment import grow_largest, mutual_nearest, spread_starts
from palpate.vision.motion import interpolate_motion
from palpate.vision.observed_layout import ObservedLayout
from palpate.vision.pattern import MarkerPattern, PatternFit
from palpate.vision.segment import MEDIAN_DISTANCE, MEDIAN_SD

_PATCH, _PATCHES, _INNER = 11, 3, 0.75
"""Markers per patch, number of patches, and maximum distance from the centre over the layout's radius.
By hand."""
_SCALES, _ANGLE_STEP_DEG = (0.8, 0.9, 1.0, 1.1, 1.25), 4.0
"""Scales and angle step of the placements of a patch. By hand."""
_TRIES = 12
"""Number of blobs per patch from which an assignment is grown. By hand."""
_STEP, _LEAST_GROWN, _ROUNDS = 0.4, 0.4, 8
"""Reach of a step of the growth, minimum share of the markers, maximum number of fits. By hand."""
_ROUGH = 0.12
"""Maximum residual over the spacing. By hand."""
_STRANGE, _STRANGE_SHARE = 5, 0.03
"""Maximum number of unassigned blobs in and around the print: constant, and per marker. By hand."""
_CHANCE, _RIVAL = 1e-8, 0.94
"""Maximum probability that random blobs fit as well; maximum relative size of a rival fit. By hand."""
_MOST_MARK = 0.05
"""Maximum standard deviation of the orientation mark about its place, over the spacing. By hand."""

_POWERS = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
"""Powers of x and y of the terms up to third order."""
_LEAST_FREE = 6
"""Excess of blobs over unknowns from which the residuals determine the spread. By hand."""


class _Grown(NamedTuple):
    blob: NDArray[np.intp]
    places: FloatArray
    residual: float
    mirror: bool

    @property
    def named(self) -> int:
        return int((self.blob >= 0).sum())


def fit_free_pattern(blobs_px: FloatArray, pattern: MarkerPattern) -> PatternFit | None:
    """Fit the pattern to blobs (n, 2); `None` if there are too few."""
    if len(blobs_px) < 3 or len(pattern) < 3 or len(np.unique(blobs_px, axis=0)) < 3:
        return None
    grown: list[_Grown] = []
    for mirror in (False,) if pattern.mirrored.any() else (False, True):
        template = pattern.expected_px * [1.0, -1.0 if mirror else 1.0]
        placements = _Placements(template, blobs_px)
        anchors = spread_starts(template, np.ones(len(template), bool), _INNER, _PATCHES)
        starts = (start for anchor in anchors for start in placements.lay(anchor))
        grown += [
            placements.fit(blob, mirror)
            for blob in grow_largest(starts, placements.near, blobs_px, _STEP, _LEAST_GROWN)
        ]
    if not grown:
        return None
    grown.sort(key=lambda each: (-each.named, each.residual))
    best = grown[0]
    rivals = [each.named for each in grown[1:] if not _same(each, best, pattern)]
    marks, axes = _marks(best, blobs_px, pattern)
    doubt = _doubt(best, blobs_px, pattern.spacing_px, max(rivals, default=0))
    return PatternFit(best.blob, best.places, best.residual, best.mirror, marks, axes, doubt)


class _Placements:
    """Assignments of one template (m, 2) among blobs (n, 2), grown from placed patches."""

    def __init__(self, template: FloatArray, blobs: FloatArray) -> None:
        self.template, self.blobs = template, blobs
        self.near = ObservedLayout(template).neighbours
        self.own, self.tree = cKDTree(template), cKDTree(blobs)
        room = self.own.query(template, 2)[0][:, 1]
        self.pitch = float(np.median(room))
        self.step = np.minimum(room, self.pitch)
        margin = int(np.ceil(4 * self.pitch)) + 4
        self.origin = np.floor(blobs.min(axis=0)) - margin
        grid = np.ones(np.ceil(np.ptp(blobs, axis=0)).astype(int)[::-1] + 2 * margin + 2, bool)
        cells = np.rint(blobs - self.origin).astype(int)
        grid[cells[:, 1], cells[:, 0]] = False
        self.likely = np.maximum(0.0, 1.0 - (distance_transform_edt(grid) / (REACH * self.pitch)) ** 2)

    def lay(self, anchor: int) -> Iterator[tuple[FloatArray, IntArray]]:
        """Yield placements (m, 2) of the template by a patch that covers most blobs, with these blobs (m,)."""
        patch = self.own.query(self.template[anchor], min(_PATCH, len(self.template)))[1]
        angle = np.radians(np.arange(0.0, 360.0, _ANGLE_STEP_DEG))
        turn = np.stack(
            [np.stack([np.cos(angle), np.sin(angle)], -1), np.stack([-np.sin(angle), np.cos(angle)], -1)], 1
        )
        moves = (np.array(_SCALES)[:, None, None, None] * turn[None]).reshape(-1, 2, 2)
        laid = (self.template[patch] - self.template[anchor]) @ moves
        score = np.empty((len(laid), len(self.blobs)))
        limit = np.array(self.likely.shape)[::-1] - 1
        for number, blob in enumerate(self.blobs):
            cell = np.clip(np.rint(laid + (blob - self.origin)).astype(int), 0, limit)
            score[:, number] = self.likely[cell[..., 1], cell[..., 0]].sum(axis=1)
        best = score.argmax(axis=0)
        first = np.argsort(-score.max(axis=0), kind="stable")[:_TRIES]
        for number in first:
            whole = (self.template - self.template[anchor]) @ moves[best[number]] + self.blobs[number]
            start = np.full(len(whole), -1)
            start[patch] = mutual_nearest(whole[patch], self.tree, np.full(len(patch), REACH * self.pitch))
            yield whole, start

    def fit(self, blob: IntArray, mirror: bool) -> _Grown:
        """Fit a smooth map to an assignment (m,) and assign by it, until nothing changes."""
        places, before = self.template, np.empty(0, int)
        for _ in range(_ROUNDS):
            if (blob >= 0).sum() < 4 or np.array_equal(blob, before):
                break
            before, places = blob, self._predict(blob)
            blob = mutual_nearest(places, self.tree, REACH * self.step)
        if (blob >= 0).sum() < 4:
            return _Grown(blob, places, np.inf, mirror)
        left = np.linalg.norm(self.blobs[blob] - places, axis=1)
        spread = MEDIAN_SD / MEDIAN_DISTANCE * float(np.median(left[blob >= 0]))
        reach = np.minimum(max(STRAY * spread, LEAST_REACH_PX), PRINT_REACH * self.step)
        blob = mutual_nearest(places, self.tree, reach)
        left = np.linalg.norm(self.blobs[blob] - places, axis=1)[blob >= 0]
        return _Grown(blob, places, float(np.sqrt(np.mean(left**2) / 2.0)) if len(left) else np.inf, mirror)

    def _predict(self, blob: IntArray) -> FloatArray:
        """Predict each marker (m, 2) by a smooth map of the assigned markers around it, excluding itself."""
        points, pixels = self.template[blob >= 0], self.blobs[blob[blob >= 0]]
        terms = next(terms for terms, least in ((10, 30), (6, 12), (3, 0)) if len(points) >= least)
        whole = fit_warp(points, pixels, terms, self.template)
        return whole(self.template) + interpolate_motion(points, pixels - whole(points), self.template)


def _same(one: _Grown, other: _Grown, pattern: MarkerPattern) -> bool:
    """Return whether two assignments are equal up to a symmetry of the layout."""
    if one.mirror != other.mirror:
        return False
    turned = one.blob[pattern.symmetries]
    return bool(((turned == other.blob) & (other.blob >= 0)).sum(axis=1).max() > 0.5 * max(one.named, 1))


def _doubt(best: _Grown, blobs: FloatArray, spacing: float, rival: int) -> str:
    """Return the reason to doubt the best assignment, or an empty string."""
    if best.residual > _ROUGH * spacing:
        return f"their residual about a smooth map is {best.residual:.1f} px"
    if rival > _RIVAL * best.named:
        return f"in another placement {rival} fit as well"
    free = np.delete(blobs, best.blob[best.blob >= 0], axis=0)
    hull = best.places[ConvexHull(best.places).vertices]
    wide = Delaunay(
        hull.mean(axis=0) + (1.0 + 2.6 * spacing / np.ptp(hull, axis=0).min()) * (hull - hull.mean(axis=0))
    )
    strange = int((wide.find_simplex(free) >= 0).sum()) if len(free) else 0
    if strange > _STRANGE + _STRANGE_SHARE * best.named:
        return f"{strange} other blobs lie between and around them"
    area = max(float(np.prod(np.ptp(blobs, axis=0))), 1.0)
    one = 1.0 - np.exp(-len(blobs) * np.pi * (PRINT_REACH * spacing) ** 2 / area)
    chance = float(binom.sf(best.named - 4, len(best.blob) - 3, one)) if best.named > 3 else 1.0
    return "" if chance < _CHANCE else f"random blobs fit as well with a probability of {chance:.0e}"


def _marks(best: _Grown, blobs: FloatArray, pattern: MarkerPattern) -> tuple[FloatArray | None, FloatArray | None]:
    """Predict the orientation mark under each symmetry, with the axes of its standard deviations."""
    have = best.blob >= 0
    terms = next((terms for terms in (10, 6, 3) if have.sum() >= 2 * terms), 0)
    if pattern.marks_px is None or not terms:
        return None, None
    flip = np.array([1.0, -1.0 if best.mirror else 1.0])
    warp = fit_warp(pattern.expected_px[have] * flip, blobs[best.blob[have]], terms, pattern.expected_px * flip)
    marks = warp(pattern.marks_px * flip)
    sd = np.maximum(warp.deviation_px(pattern.marks_px * flip), MARK_PX)
    sd = np.minimum(sd, _MOST_MARK * pattern.spacing_px)
    return marks, sd[:, None, None] * np.eye(2)


@dataclass(frozen=True, eq=False)
class Warp:
    """Polynomial in the pattern's plane, fitted by least squares.

    Attributes
    ----------
    middle, size
        Origin (2,) and unit of the polynomial's variables, px of the pattern.
    weights, inverse
        (k, 2) coefficients of the terms, px of the image, and (k, k) inverse of the normal equations.
    spread_px
        Standard deviation of a blob coordinate about the map; infinite if too few blobs determine it.
    """

    middle: FloatArray
    size: float
    weights: FloatArray
    inverse: FloatArray
    spread_px: float

    def __call__(self, points: FloatArray) -> FloatArray:
        """Map points (n, 2) of the pattern to pixels (n, 2)."""
        moved: FloatArray = self._terms(points) @ self.weights
        return moved

    def deviation_px(self, points: FloatArray) -> FloatArray:
        """Return the standard deviation (n,) of a coordinate of one more blob at points (n, 2) of the pattern.

        It is s √(1 + aᵀ (AᵀA)⁻¹ a) with the terms a there, which includes the uncertainty of the map outside the
        blobs.
        """
        terms = self._terms(points)
        return np.asarray(self.spread_px * np.sqrt(1.0 + np.einsum("ni,ij,nj->n", terms, self.inverse, terms)))

    def _terms(self, points: FloatArray) -> FloatArray:
        return _terms((points - self.middle) / self.size, len(self.weights))


def fit_warp(points: FloatArray, pixels: FloatArray, terms: int, whole: FloatArray) -> Warp:
    """Fit a polynomial of 3 (affine), 6 or 10 (cubic) terms to blobs (n, 2) in pattern and image, px.

    All points (m, 2) of the pattern, `whole`, determine its origin and unit.
    """
    middle, size = whole.mean(axis=0), float(np.ptp(whole, axis=0).max()) / 2.0
    design = _terms((points - middle) / size, terms)
    inverse = np.asarray(np.linalg.pinv(design.T @ design), float)
    weights = np.asarray(inverse @ (design.T @ pixels), float)
    free = len(points) - terms
    left = pixels - design @ weights
    # a false dot taken for a marker must not widen what is believed: the median forgives it
    spread = (
        MEDIAN_SD * float(np.median(np.abs(left))) * np.sqrt(len(points) / free) if free >= _LEAST_FREE else np.inf
    )
    return Warp(middle, size, weights, inverse, spread)


def _terms(points: FloatArray, count: int) -> FloatArray:
    x, y = points[:, 0], points[:, 1]
    return np.stack([np.ones(len(points)), *(x**a * y**b for a, b in _POWERS[: count - 1])], axis=-1)
