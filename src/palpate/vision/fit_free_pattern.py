"""Fit of a free layout among blobs: patches of neighbouring markers that fit, grown over neighbours.

A few neighbouring markers are laid over every blob, turned and scaled; from those that cover most blobs, the
assignment grows (`palpate.vision.grow_assignment`). A smooth map is then fitted to it and markers are assigned by
the map, so the print may be bent as a whole as long as it is smooth. If another place explains as many markers, the
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
from palpate.vision.grow_assignment import grow_largest, mutual_nearest, spread_starts
from palpate.vision.motion import interpolate_motion
from palpate.vision.observed_layout import ObservedLayout
from palpate.vision.pattern import MarkerPattern, PatternFit

_PATCH, _PATCHES, _INNER = 11, 3, 0.75
"""Markers of a patch, number of patches, and their distance from the middle over the layout's radius."""
_SCALES, _ANGLE_STEP_DEG = (0.8, 0.9, 1.0, 1.1, 1.25), 4.0
"""Scales and step of the turns in which a patch is laid."""
_TRIES = 12
"""Blobs of each patch from which an assignment is grown."""
_STEP, _LEAST_GROWN, _ROUNDS = 0.4, 0.4, 8
"""Reach of a step of the growth, minimum share of the markers for a fit, and largest number of fits."""
_REACH, _PRINT_REACH = 0.3, 0.22
"""Largest distance of a blob from its predicted place in the fits and in the last, over the spacing."""
_STRAY, _LEAST_REACH_PX = 4.5, 0.7
"""Largest distance in the last fit over the spread of all blobs, and the reach that is always allowed."""
_ROUGH = 0.12
"""Largest residual over the spacing."""
_STRANGE, _STRANGE_SHARE = 5, 0.03
"""Dots within the print and a spacing beside it that are of no marker: so many, and more for each that is."""
_CHANCE, _RIVAL = 1e-8, 0.94
"""Probability that random blobs fit as well, and share of the markers at a rival place, at most."""
_LEAST_MARK_PX, _MOST_MARK = 0.2, 0.05
"""Standard deviation of the orientation mark about its place, at least, and at most over the spacing."""

_POWERS = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]
_LEAST_FREE = 6
"""Dots more than unknowns from which on the residuals tell the spread."""


class _Grown(NamedTuple):
    blob: NDArray[np.intp]
    places: FloatArray
    residual: float
    mirror: bool

    @property
    def named(self) -> int:
        return int((self.blob >= 0).sum())


def fit_free_pattern(blobs_px: FloatArray, pattern: MarkerPattern) -> PatternFit | None:
    """The pattern among dots (n, 2); `None` where there are too few."""
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
    """Assignments of one template (m, 2) among blobs (n, 2), grown from patches laid over them."""

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
        self.likely = np.maximum(0.0, 1.0 - (distance_transform_edt(grid) / (_REACH * self.pitch)) ** 2)

    def lay(self, anchor: int) -> Iterator[tuple[FloatArray, IntArray]]:
        """Template (m, 2) laid so that a patch about a marker covers most blobs, and those of the patch (m,)."""
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
            start[patch] = mutual_nearest(whole[patch], self.tree, np.full(len(patch), _REACH * self.pitch))
            yield whole, start

    def fit(self, blob: IntArray, mirror: bool) -> _Grown:
        """Fit a smooth map to an assignment (m,) and assign by it until nothing changes."""
        places, before = self.template, np.empty(0, int)
        for _ in range(_ROUNDS):
            if (blob >= 0).sum() < 4 or np.array_equal(blob, before):
                break
            before, places = blob, self._predict(blob)
            blob = mutual_nearest(places, self.tree, _REACH * self.step)
        if (blob >= 0).sum() < 4:
            return _Grown(blob, places, np.inf, mirror)
        left = np.linalg.norm(self.blobs[blob] - places, axis=1)
        spread = 1.4826 / 1.1774 * float(np.median(left[blob >= 0]))
        reach = np.minimum(max(_STRAY * spread, _LEAST_REACH_PX), _PRINT_REACH * self.step)
        blob = mutual_nearest(places, self.tree, reach)
        left = np.linalg.norm(self.blobs[blob] - places, axis=1)[blob >= 0]
        return _Grown(blob, places, float(np.sqrt(np.mean(left**2) / 2.0)) if len(left) else np.inf, mirror)

    def _predict(self, blob: IntArray) -> FloatArray:
        """(m, 2) each marker by a smooth map of the assigned ones about it, itself left out."""
        points, pixels = self.template[blob >= 0], self.blobs[blob[blob >= 0]]
        terms = next(terms for terms, least in ((10, 30), (6, 12), (3, 0)) if len(points) >= least)
        whole = fit_warp(points, pixels, terms, self.template)
        return whole(self.template) + interpolate_motion(points, pixels - whole(points), self.template)


def _same(one: _Grown, other: _Grown, pattern: MarkerPattern) -> bool:
    """Whether two namings are one, but for a symmetry of the layout."""
    if one.mirror != other.mirror:
        return False
    turned = one.blob[pattern.symmetries]
    return bool(((turned == other.blob) & (other.blob >= 0)).sum(axis=1).max() > 0.5 * max(one.named, 1))


def _doubt(best: _Grown, blobs: FloatArray, spacing: float, rival: int) -> str:
    """What speaks against the best naming."""
    if best.residual > _ROUGH * spacing:
        return f"they lie {best.residual:.1f} px off a smooth map"
    if rival > _RIVAL * best.named:
        return f"laid elsewhere, {rival} fit as well"
    free = np.delete(blobs, best.blob[best.blob >= 0], axis=0)
    hull = best.places[ConvexHull(best.places).vertices]
    wide = Delaunay(
        hull.mean(axis=0) + (1.0 + 2.6 * spacing / np.ptp(hull, axis=0).min()) * (hull - hull.mean(axis=0))
    )
    strange = int((wide.find_simplex(free) >= 0).sum()) if len(free) else 0
    if strange > _STRANGE + _STRANGE_SHARE * best.named:
        return f"{strange} other dots lie between and beside them"
    area = max(float(np.prod(np.ptp(blobs, axis=0))), 1.0)
    one = 1.0 - np.exp(-len(blobs) * np.pi * (_PRINT_REACH * spacing) ** 2 / area)
    chance = float(binom.sf(best.named - 4, len(best.blob) - 3, one)) if best.named > 3 else 1.0
    return "" if chance < _CHANCE else f"dots strewn at random do as well with a chance of {chance:.0e}"


def _marks(best: _Grown, blobs: FloatArray, pattern: MarkerPattern) -> tuple[FloatArray | None, FloatArray | None]:
    """Where the orientation mark would be under each symmetry, and the axes of its standard deviations."""
    have = best.blob >= 0
    terms = next((terms for terms in (10, 6, 3) if have.sum() >= 2 * terms), 0)
    if pattern.marks_px is None or not terms:
        return None, None
    flip = np.array([1.0, -1.0 if best.mirror else 1.0])
    warp = fit_warp(pattern.expected_px[have] * flip, blobs[best.blob[have]], terms, pattern.expected_px * flip)
    marks = warp(pattern.marks_px * flip)
    sd = np.maximum(warp.deviation_px(pattern.marks_px * flip), _LEAST_MARK_PX)
    sd = np.minimum(sd, _MOST_MARK * pattern.spacing_px)
    return marks, sd[:, None, None] * np.eye(2)


@dataclass(frozen=True, eq=False)
class Warp:
    """Polynomial in the pattern's plane, fitted by least squares.

    Attributes
    ----------
    middle, size
        Origin (2,) and unit of the polynomial's variables, px of the pattern.
    weights
        (k, 2) factors of the terms, px of the image.
    inverse
        (k, k) inverse of the normal equations.
    spread_px
        Standard deviation of a coordinate of a dot about the map; infinite where too few dots tell it.
    """

    middle: FloatArray
    size: float
    weights: FloatArray
    inverse: FloatArray
    spread_px: float

    def __call__(self, points: FloatArray) -> FloatArray:
        """Pixels (n, 2) of points (n, 2) of the pattern."""
        moved: FloatArray = self._terms(points) @ self.weights
        return moved

    def deviation_px(self, points: FloatArray) -> FloatArray:
        """(n,) standard deviation of a coordinate of one more dot at points (n, 2) of the pattern.

        It is s √(1 + aᵀ (AᵀA)⁻¹ a) with a the terms there: beyond the outermost dots the map itself is less sure.
        """
        terms = self._terms(points)
        return np.asarray(self.spread_px * np.sqrt(1.0 + np.einsum("ni,ij,nj->n", terms, self.inverse, terms)))

    def _terms(self, points: FloatArray) -> FloatArray:
        return _terms((points - self.middle) / self.size, len(self.weights))


def fit_warp(points: FloatArray, pixels: FloatArray, terms: int, whole: FloatArray) -> Warp:
    """Fit the map.

    Parameters
    ----------
    points, pixels
        (n, 2) dots in the pattern's plane and in the image, px.
    terms
        Terms of the polynomial: 3 affine, 6 of second order, 10 of third.
    whole
        (m, 2) all points of the pattern, which give origin and unit.
    """
    middle, size = whole.mean(axis=0), float(np.ptp(whole, axis=0).max()) / 2.0
    design = _terms((points - middle) / size, terms)
    inverse = np.asarray(np.linalg.pinv(design.T @ design), float)
    weights = np.asarray(inverse @ (design.T @ pixels), float)
    free = len(points) - terms
    left = pixels - design @ weights
    # a false dot taken for a marker must not widen what is believed: the median forgives it
    spread = 1.4826 * float(np.median(np.abs(left))) * np.sqrt(len(points) / free) if free >= _LEAST_FREE else np.inf
    return Warp(middle, size, weights, inverse, spread)


def _terms(points: FloatArray, count: int) -> FloatArray:
    x, y = points[:, 0], points[:, 1]
    return np.stack([np.ones(len(points)), *(x**a * y**b for a, b in _POWERS[: count - 1])], axis=-1)
