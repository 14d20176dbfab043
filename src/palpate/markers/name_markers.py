"""Assignment of dots at rest to markers (naming), for a camera whose pose is not known well.

1. The pattern is laid over the dots for every turn and shift of a coarse grid, scored by how many dots lie near.
2. From the best of these, nearest neighbours and a smooth map (similarity, then affine, then polynomial) improve each
   other, as in iterated closest points; the map with the most markers on dots is kept.
3. A layout of rings looks the same turned by 60° and in a mirror. The orientation mark tells these apart; without it
   the numbers are given for the smallest turn and marked as ambiguous.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.markers.pattern import MarkerPattern
from palpate.markers.warp import Warp, fit_warp

_REACH = 0.45
"""How near a dot is, over the spacing of the markers."""
_PRINT_REACH = 0.15
"""The same once the map has settled: no dot is printed farther from its place, and what lies farther is false."""
_MARK_REACH = 4.0
"""How far the orientation mark may lie from its place, over the standard deviation of a dot about the map there."""
_LEAST_MARK_REACH_PX = 0.6
"""The mark lies beyond the others: where all of the print is 0.2 mm off, the map misses it by up to 0.5 px."""
_CHANCE = 1e-3
"""Chance of a false dot in the mark's place, with the mark itself hidden, above which the mark is not believed."""
_SHIFTS_PX, _SHIFT_STEP_PX, _ANGLE_STEP_DEG = 15.0, 3.0, 2.0
_TRIES = 8
_LEAST_SHARE = 0.5
"""Share of the markers that must be found for a naming to be believed."""


@dataclass(frozen=True, eq=False)
class Naming:
    """Which dot is which marker.

    Attributes
    ----------
    blob
        (m,) number of the blob of each marker, -1 where there is none.
    positions_px
        (m, 2) its pixels; where there is no blob, where the map expects it.
    found
        (m,) whether there is a blob.
    turn_deg, mirrored
        How the pattern lies in the image against the nominal camera, turned in the sense from column to row.
    alternatives
        Other namings that fit as well, without alternatives of their own; empty where there is one only.
    mark
        Number of the blob that is the orientation mark, -1 where none was seen.
    residual_px
        Root of the mean squared distance between dots and the smooth map.
    """

    blob: NDArray[np.intp]
    positions_px: FloatArray
    found: BoolArray
    turn_deg: float
    mirrored: bool
    alternatives: tuple[Naming, ...]
    mark: int
    residual_px: float

    @property
    def ambiguous(self) -> bool:
        """Whether other namings fit as well."""
        return len(self.alternatives) > 0


def name_markers(blobs_px: FloatArray, pattern: MarkerPattern) -> Naming:
    """Give every marker its dot.

    Parameters
    ----------
    blobs_px
        (n, 2) centres of the dots at rest, some missing, some false.
    pattern
        What is expected.

    Raises
    ------
    PalpateError
        If fewer than half of the markers find a dot: another design, or an image that is not at rest.
    """
    blobs_px = np.asarray(blobs_px, float).reshape(-1, 2)
    best: tuple[int, float, Warp, NDArray[np.intp], bool] | None = None
    if len(blobs_px) >= 3:
        tree = cKDTree(blobs_px)
        for mirror in (False,) if pattern.mirrored.any() else (False, True):
            template = pattern.expected_px * [1.0, -1.0 if mirror else 1.0]
            for start in _coarse(blobs_px, template, pattern.spacing_px):
                warp, blob, residual = _fit(template, start, blobs_px, tree, pattern.spacing_px)
                count = int((blob >= 0).sum())
                if best is None or (count, -residual) > (best[0], -best[1]):
                    best = count, residual, warp, blob, mirror
    count = best[0] if best else 0
    if best is None or count < max(3, _LEAST_SHARE * len(pattern)):
        raise PalpateError(
            f"{count} of {len(pattern)} markers were found among {len(blobs_px)} dots.",
            "Check that design and camera are those of the image, and that the dome is at rest.",
        )
    return _resolve(blobs_px, pattern, best[2], best[3], (best[4], best[1]))


def _coarse(blobs: FloatArray, template: FloatArray, spacing: float) -> list[FloatArray]:
    """The template laid over the dots by the best turns and shifts, best first."""
    margin = 4 * int(np.ceil(np.ptp(template, axis=0).max() / 4)) + 40
    origin = np.floor(blobs.min(axis=0)) - margin
    grid = np.ones(np.ceil(np.ptp(blobs, axis=0)).astype(int)[::-1] + 2 * margin + 2, bool)
    cells = np.rint(blobs - origin).astype(int)
    grid[cells[:, 1], cells[:, 0]] = False
    near = np.maximum(0.0, 1.0 - (distance_transform_edt(grid) / (_REACH * spacing)) ** 2).astype(np.float32)
    middle, centre = template.mean(axis=0), np.median(blobs, axis=0) / 2.0 + blobs.mean(axis=0) / 2.0
    shifts = np.arange(-_SHIFTS_PX, _SHIFTS_PX + 1e-9, _SHIFT_STEP_PX)
    offsets = np.stack(np.meshgrid(shifts, shifts), axis=-1).reshape(-1, 2)
    laid, scores = [], []
    for angle in np.radians(np.arange(0.0, 360.0, _ANGLE_STEP_DEG)):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turned = (template - middle) @ turn.T + centre
        cell = np.rint(turned[None] + offsets[:, None] - origin).astype(int)
        cell = np.clip(cell, 0, np.array(near.shape)[::-1] - 1)
        score = near[cell[..., 1], cell[..., 0]].sum(axis=1)
        top = np.argsort(-score)[:2]
        laid += [turned + offsets[k] for k in top]
        scores += [float(score[k]) for k in top]
    return [laid[k] for k in np.argsort(-np.array(scores), kind="stable")[:_TRIES]]


def _fit(
    template: FloatArray, laid: FloatArray, blobs: FloatArray, tree: cKDTree, spacing: float
) -> tuple[Warp, NDArray[np.intp], float]:
    """Neighbours and map in turn; the map gains freedom as it settles."""
    freedom = [3, 3, 3, 6, 6, 6] + ([10, 10] if len(template) > 60 else [6])
    warp = fit_warp(template, laid, 3, template)
    blob = np.full(len(template), -1)
    for number, terms in enumerate(freedom):
        blob = _neighbours(laid, blobs, tree, spacing * (_REACH if number < 4 else 0.33))
        have = blob >= 0
        if have.sum() < 2 * terms:
            break
        warp = fit_warp(template[have], blobs[blob[have]], terms, template)
        laid = warp(template)
    blob = _assign(laid, blobs, tree, _PRINT_REACH * spacing)
    have = blob >= 0
    miss = blobs[blob[have]] - laid[have]
    return warp, blob, float(np.sqrt(np.mean(miss**2))) if have.any() else np.inf


def _neighbours(laid: FloatArray, blobs: FloatArray, tree: cKDTree, reach: float) -> NDArray[np.intp]:
    """Nearest dot of each marker, where the marker is also the nearest of the dot."""
    distance, blob = tree.query(laid, distance_upper_bound=reach)
    back = cKDTree(laid).query(blobs)[1]
    blob = np.where(np.isfinite(distance), blob, -1)
    mutual = (blob >= 0) & (back[blob] == np.arange(len(laid)))
    return np.where(mutual, blob, -1)


def _assign(laid: FloatArray, blobs: FloatArray, tree: cKDTree, reach: float) -> NDArray[np.intp]:
    """The assignment of least total squared distance, none longer than `reach`."""
    cost = np.full((len(laid), len(blobs)), reach**2)
    for marker, near in enumerate(tree.query_ball_point(laid, reach)):
        cost[marker, near] = ((blobs[near] - laid[marker]) ** 2).sum(axis=1)
    marker, blob = linear_sum_assignment(cost)
    result = np.full(len(laid), -1)
    result[marker] = np.where(cost[marker, blob] < reach**2, blob, -1)
    return result


def _resolve(
    blobs: FloatArray, pattern: MarkerPattern, warp: Warp, blob: NDArray[np.intp], seen: tuple[bool, float]
) -> Naming:
    """Choose among the turns and mirrors that fit as well: by the mark, else the smallest turn, and say so."""
    flip = np.array([1.0, -1.0 if seen[0] else 1.0])
    middle = pattern.expected_px.mean(axis=0)
    tip = warp(np.stack([middle, middle + np.array([1.0, 0.0])]) * flip)
    turn = float(np.degrees(np.arctan2(*(tip[1] - tip[0])[::-1])))
    choices, mark = _find_mark(blobs, pattern, warp, blob, flip)
    # the pattern moved by a symmetry fits as well: the whole then is turned by as much less
    turns = (turn + pattern.turns_deg[choices] + 180.0) % 360.0 - 180.0
    expected = np.where(blob[:, None] >= 0, blobs[blob], warp(pattern.expected_px * flip))
    namings = []
    for rank in np.lexsort([np.abs(turns), pattern.mirrored[choices]]):
        # the dot at the place of marker i is marker order[i]
        order = np.argsort(pattern.symmetries[choices[rank]])
        namings.append(
            Naming(
                blob=blob[order],
                positions_px=expected[order],
                found=blob[order] >= 0,
                turn_deg=float(turns[rank]),
                mirrored=bool(pattern.mirrored[choices[rank]] != seen[0]),
                alternatives=(),
                mark=mark,
                residual_px=seen[1],
            )
        )
    return replace(namings[0], alternatives=tuple(namings[1:]))


def _find_mark(
    blobs: FloatArray, pattern: MarkerPattern, warp: Warp, blob: NDArray[np.intp], flip: FloatArray
) -> tuple[NDArray[np.intp], int]:
    """Numbers of the symmetries that the orientation mark leaves, and its dot: -1 where it does not decide.

    The mark is a dot that belongs to no marker and lies where the map expects it, as surely as the map knows. It is
    not believed where so many false dots lie about that one of them could as well be there while the mark is hidden.
    """
    every = np.arange(len(pattern.symmetries))
    free = np.setdiff1d(np.arange(len(blobs)), blob[blob >= 0])
    if pattern.marks_px is None or not len(free):
        return every, -1
    places = pattern.marks_px * flip
    reach = np.maximum(_MARK_REACH * warp.deviation_px(places), _LEAST_MARK_REACH_PX)
    reach = np.minimum(reach, _PRINT_REACH * pattern.spacing_px)
    distance = np.linalg.norm(blobs[free][None] - warp(places)[:, None], axis=-1)
    near = np.argwhere(distance < reach[:, None])
    choices = np.unique(near[:, 0])
    if len(choices) != 1:
        return (choices if len(choices) else every), -1
    hidden = (1.0 + (blob < 0).sum()) / (2.0 + len(blob))
    crowd = (len(free) - 1) / float(np.prod(np.ptp(blobs, axis=0)))
    if hidden * crowd * np.pi * float((reach**2).sum()) > _CHANCE:
        return every, -1
    return choices, int(free[near[np.argmin(distance[near[:, 0], near[:, 1]]), 1]])
