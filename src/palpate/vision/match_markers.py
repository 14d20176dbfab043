"""Correspondence between the layout and the blobs of a single image, at large displacements.

A guess of the displacement is refined iteratively: mutual nearest neighbours are assigned, and a smooth field is
fitted to them. Guesses come from assigned images with a similar distribution of blobs. If none succeeds, assignments
are grown from some central markers, each assigned to every possible blob (`palpate.vision.grow_assignment`). On a
regular pattern an assignment may be shifted by a whole row. Then a row of blobs is unassigned on one side and a row
of markers on the opposite side, and the irregularity of the print does not fit. So an assignment is accepted only if
it leaves hardly any blob or marker unassigned, is smooth, and no other one explains the image nearly as well.
Otherwise the image is rejected, with the reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray, IntArray
from palpate.vision.grow_assignment import (
    assignment_residuals,
    grow_assignment,
    grow_largest,
    mutual_nearest,
    spread_starts,
)
from palpate.vision.motion import MotionModel
from palpate.vision.neighbours import largest_group
from palpate.vision.observed_layout import ObservedLayout

GRID = 20
"""Cells per side of the histogram of blob positions by which similar images are found. By hand."""
_NEAR, _WIDE = 0.42, 0.55
"""Maximum distance of a blob from its prediction, last and first iteration, over spacing. By hand."""
_TURNS, _STIFF = 6, 0.02
"""Maximum number of iterations, and weight of a field's roughness relative to one blob. By hand."""
_SURE, _BELIEVED, _APART = 0.97, 0.86, 0.02
"""Agreement above which no alternative is searched, above which one is accepted, and its minimum lead.
By hand."""
_CALM, _ROUGH = 0.035, 0.06
"""Maximum RMS distance from the smooth field, over the spacing, of confident and of accepted images.
By hand."""
_STEP, _TORN = 0.45, 0.16
"""Maximum relative distance from the neighbours' prediction: growth, consistent parts. By hand."""
_MAX_RESIDUAL = 0.2
"""Minimum distance of a false blob from its neighbours' prediction, over theirs. By hand."""
_LESS = 0.08
"""Maximum deficit of agreement of an accepted image relative to confident ones. By hand."""
_REACH = 4.5
"""Maximum displacement that is tried for a start, over the spacing. By hand."""
_STARTS, _INNER, _ALIKE, _KEPT = 5, 0.65, 4, 400
"""Number of start markers, and their maximum distance from the centre over the layout's radius.

Then the number of assignments and similar images that are refined, and of images stored as guesses. By hand.
"""


class MatchFault(StrEnum):
    """Reason to reject a correspondence."""

    NONE = ""
    NO_DOTS = "no blobs were found"
    LEFT_OVER = "too many blobs are unassigned"
    ROUGH = "the blobs do not move like a skin"
    AMBIGUOUS = "two assignments explain the image equally well"
    PICTURE = "markers and pixels give different poses"


@dataclass(frozen=True, eq=False)
class Correspondence:
    """Markers of one image by their index in the layout.

    Attributes
    ----------
    moved_px
        (m, 2) displacement from rest; by the smooth field if no blob was assigned.
    blob
        (m,) index of the assigned blob, -1 without one.
    agreement
        Twice the number of assigned blobs over the number of blobs plus that of markers.
    rough
        Root mean square distance from the smooth field, over the spacing.
    fault
        Reason to reject it; `MatchFault.NONE` if accepted.
    confident
        Whether no alternative needs to be searched.
    """

    moved_px: FloatArray
    blob: IntArray
    agreement: float
    rough: float
    fault: MatchFault = MatchFault.NONE
    confident: bool = False

    @property
    def found(self) -> BoolArray:
        """Whether a blob was assigned to each marker (m,)."""
        return self.blob >= 0

    @property
    def accepted(self) -> bool:
        """Whether it is accepted."""
        return self.fault is MatchFault.NONE

    @property
    def score(self) -> float:
        """Measure that is highest for the best assignment of an image."""
        return self.agreement - 2.0 * self.rough


def marker_descriptor(dots_px: FloatArray, shape: tuple[float, float]) -> FloatArray:
    """Return a smoothed histogram (GRID²,) of blob positions, of unit length, to compare images."""
    cells = np.zeros((GRID + 1, GRID + 1))
    if len(dots_px):
        place = np.clip(dots_px / np.array(shape[::-1]) * GRID, 0, GRID - 1e-6)
        corner = place.astype(int)
        part = place - corner
        for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
            weight = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
            np.add.at(cells, (corner[:, 1] + dy, corner[:, 0] + dx), weight)
    for axis in (0, 1):
        padded = np.pad(cells, [(1, 1) if k == axis else (0, 0) for k in (0, 1)])
        first, middle, last = (np.take(padded, range(k, k + GRID + 1), axis) for k in range(3))
        cells = 0.25 * first + 0.5 * middle + 0.25 * last
    flat = cells[:GRID, :GRID].ravel()
    return np.asarray(flat / max(float(np.linalg.norm(flat)), 1e-9))


@dataclass(eq=False)
class MarkerMatcher:
    """Search of correspondences, with a memory of confident images as guesses for further ones.

    Attributes
    ----------
    layout
        Markers at rest.
    shape
        Height and width of the images, px.
    seen, fields
        (k, GRID²) and (k, m, 2) descriptors and displacements of confident images.
    smooth
        Whether markers must move as a smooth field; without it each takes the blob nearest to its rest place.
    motions
        Joint motion of this sensor's markers; `None` accepts any smooth field.
    usual
        Agreement and roughness of a confident image; an accepted one may be somewhat worse.
    """

    layout: ObservedLayout
    shape: tuple[int, int]
    seen: list[FloatArray] = field(default_factory=list)
    fields: list[FloatArray] = field(default_factory=list)
    smooth: bool = True
    motions: MotionModel | None = None
    usual: tuple[float, float] = (_SURE, _CALM)

    def to_arrays(self) -> tuple[FloatArray, FloatArray]:
        """Return motions (1 + k, 2m), empty if not fitted, and (3,) `usual` and their noise, for a file."""
        known = self.motions
        motion = (
            np.zeros((0, 0))
            if known is None or known.modes_px is None
            else np.concatenate([known.mean_px[None], known.modes_px]).reshape(-1, 2 * len(self.layout))
        )
        return motion, np.array([*self.usual, 0.0 if known is None else known.noise_px])

    def with_arrays(self, motion: FloatArray, usual: FloatArray) -> MarkerMatcher:
        """Return a copy with the result of `to_arrays`."""
        known = None
        if len(motion):
            mean, *modes = motion.reshape(len(motion), -1, 2)
            known = MotionModel(self.layout.rest_px, np.array(modes), mean, float(usual[2]))
        return replace(self, motions=known, usual=(float(usual[0]), float(usual[1])))

    def find(self, dots_px: FloatArray, guesses: tuple[FloatArray, ...] = ()) -> Correspondence:
        """Find the correspondence of an image with blobs (n, 2) px.

        The displacements (m, 2) `guesses` are tried before those of similar images.
        """
        if not self.smooth:
            return self._nearest(dots_px)
        count = len(self.layout)
        if len(dots_px) < 0.4 * count:
            return Correspondence(np.zeros((count, 2)), np.full(count, -1), 0.0, 0.0, MatchFault.NO_DOTS)
        tried: list[Correspondence] = []
        for guess in (*guesses, *self._alike(dots_px)):
            tried.append(self.refine(dots_px, guess))
            if tried[-1].confident:
                return tried[-1]
        if self.motions is not None and any(one.accepted for one in tried):
            return self._choose(tried)
        for match in self._grown(dots_px):
            smooth, _ = self._field(dots_px, match)
            tried.append(self._evaluate(dots_px, *self._mend(dots_px, match, smooth)))
            tried.append(self.refine(dots_px, smooth))
            if max(tried[-2:], key=lambda one: one.score).confident:
                break
        return self._choose(tried)

    def remember(self, dots_px: FloatArray, found: Correspondence) -> None:
        """Store a confident image as a guess for further ones, up to a maximum number."""
        if found.confident and len(self.seen) < _KEPT:
            self.seen.append(marker_descriptor(dots_px, self.shape))
            self.fields.append(found.moved_px)

    def _alike(self, dots_px: FloatArray) -> list[FloatArray]:
        guesses = [np.zeros((len(self.layout), 2))]
        if self.seen:
            alike = np.array(self.seen) @ marker_descriptor(dots_px, self.shape)
            guesses = [self.fields[k] for k in np.argsort(-alike)[:_ALIKE]]
        return guesses

    def _grown(self, dots_px: FloatArray) -> list[IntArray]:
        """Return the largest assignments that grow from a few markers of the layout."""
        layout = self.layout
        many = (layout.neighbours >= 0).sum(axis=1)
        starts = spread_starts(layout.rest_px, many >= min(6, many.max()), _INNER, _STARTS)
        tree = cKDTree(dots_px)
        seeds = (
            (layout.rest_px, np.where(np.arange(len(layout)) == start, other, -1))
            for start in starts
            for other in tree.query_ball_point(layout.rest_px[start], _REACH * layout.spacing_px[start])
        )
        return grow_largest(seeds, layout.neighbours, dots_px, _STEP, 0.3)[:_ALIKE]

    def _field(self, dots_px: FloatArray, match: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the smooth displacement (m, 2) of an assignment, and residuals (m,), NaN without a blob."""
        there = match >= 0
        moved = np.full((len(self.layout), 2), np.nan)
        moved[there] = dots_px[match[there]] - self.layout.rest_px[there]
        if self.motions is not None:
            smooth = self.motions.fit(moved, there)
            return smooth, np.asarray(np.linalg.norm(moved - smooth, axis=1))
        vectors, rough = self.layout.harmonics
        part = vectors[there]
        hold = np.diag(_STIFF * len(vectors) * rough + 1e-6)
        weights = np.linalg.solve(part.T @ part + hold, part.T @ moved[there])
        smooth = vectors @ weights
        return smooth, np.asarray(np.linalg.norm(moved - smooth, axis=1))

    def refine(self, dots_px: FloatArray, guess: FloatArray) -> Correspondence:
        """Find the correspondence near a guess of the displacement (m, 2), px, without alternatives."""
        layout, smooth, previous = self.layout, guess, b""
        tree = cKDTree(dots_px)
        for turn in range(_TURNS):
            reach = _WIDE + (_NEAR - _WIDE) * min(turn / 3, 1.0)
            match = _match(layout.rest_px + smooth, tree, reach)
            if (match >= 0).sum() < max(6, 0.2 * len(layout)):
                break
            smooth, _ = self._field(dots_px, match)
            if match.tobytes() == previous:
                break
            previous = match.tobytes()
        else:
            match = _match(layout.rest_px + smooth, tree, _NEAR)
        if self.motions is not None:
            return self._evaluate(dots_px, match, smooth)
        return self._evaluate(dots_px, *self._mend(dots_px, match, smooth))

    def _mend(self, dots_px: FloatArray, match: IntArray, smooth: FloatArray) -> tuple[IntArray, FloatArray]:
        """Remove inconsistent blobs from an assignment, and grow it again from its consistent part."""
        layout = self.layout
        for _ in range(3):
            torn = assignment_residuals(layout.rest_px, layout.neighbours, dots_px, match) > _TORN
            if not torn.any():
                break
            beside = layout.neighbours[torn]
            torn[beside[beside >= 0]] = True
            kept = np.where(torn, -1, match)
            if (kept >= 0).sum() < 0.3 * len(layout):
                break
            match = grow_assignment(
                layout.rest_px, layout.neighbours, dots_px, _largest(kept, layout.neighbours), _STEP
            )
            smooth, _ = self._field(dots_px, match)
        return match, smooth

    def _evaluate(self, dots_px: FloatArray, match: IntArray, smooth: FloatArray) -> Correspondence:
        layout, there = self.layout, match >= 0
        moved = smooth.copy()
        moved[there] = dots_px[match[there]] - layout.rest_px[there]
        # two dots that are seen as one are neither of them
        if self.motions is None:
            there &= assignment_residuals(layout.rest_px, layout.neighbours, dots_px, match) < _MAX_RESIDUAL
        off = np.linalg.norm(moved - smooth, axis=1) / layout.spacing_px
        if self.motions is not None:  # it knows better than the neighbours where a dot must be
            there &= off < _MAX_RESIDUAL
        moved[~there] = smooth[~there]
        rough = float(np.sqrt(np.mean(off[there] ** 2))) if there.any() else np.inf
        agreement = float(2 * there.sum() / (len(layout) + len(dots_px)))
        least = min(_BELIEVED, self.usual[0] - _LESS)
        fault = MatchFault.LEFT_OVER if agreement < least else MatchFault.ROUGH if rough > _ROUGH else MatchFault.NONE
        sure = fault is MatchFault.NONE and agreement >= self.usual[0] and rough <= self.usual[1]
        return Correspondence(moved, np.where(there, match, -1), agreement, rough, fault, sure)

    def _choose(self, tried: list[Correspondence]) -> Correspondence:
        best = max(tried, key=lambda one: (one.accepted, one.score))
        if not best.accepted:
            return best
        spacing = float(np.median(self.layout.spacing_px))
        others = [
            one.score
            for one in tried
            if one.accepted and np.median(np.linalg.norm(one.moved_px - best.moved_px, axis=1)) > 0.4 * spacing
        ]
        if others and max(others) > best.score - _APART:
            return replace(best, fault=MatchFault.AMBIGUOUS, confident=False)
        return best

    def _nearest(self, dots_px: FloatArray) -> Correspondence:
        if not len(dots_px):
            count = len(self.layout)
            return Correspondence(np.zeros((count, 2)), np.full(count, -1), 0.0, 0.0, MatchFault.NO_DOTS)
        match = cKDTree(dots_px).query(self.layout.rest_px)[1]
        moved = dots_px[match] - self.layout.rest_px
        return Correspondence(moved, match, 1.0, 0.0)


def _largest(match: IntArray, near: IntArray) -> IntArray:
    """Return the largest connected part of an assignment."""
    pairs = np.column_stack([np.repeat(np.arange(len(near)), near.shape[1]), near.ravel()])
    there = match >= 0
    return np.where(largest_group(pairs[(pairs[:, 1] >= 0) & there[pairs].all(axis=1)], there), match, -1)


def _match(places: FloatArray, tree: cKDTree, reach: float) -> IntArray:
    """Assign blobs (m,) to places, within a reach over the distance to the nearest three places."""
    spacing = cKDTree(places).query(places, min(4, len(places)))[0][:, 1:].mean(axis=1)
    return mutual_nearest(places, tree, reach * spacing)
