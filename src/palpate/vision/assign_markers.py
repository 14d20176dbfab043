"""Assignment of blobs at rest to markers, by an approximate camera and a possibly distorted print.

1. Rings are found by their structure: number of markers, order, and common azimuth
   (`palpate.vision.find_rings_by_structure`); free layouts by their neighbourhoods
   (`palpate.vision.fit_free_pattern`).
2. Doubtful results are rejected: a missing ring, an additional ring, rings rotated against each other, or a fit that
   random blobs would show as well.
3. A layout of rings has symmetries: rotation by 60° and mirroring. The orientation mark resolves them. Without it,
   the assignment with the smallest rotation is returned and marked as ambiguous.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.vision.fit_free_pattern import fit_free_pattern
from palpate.vision.fit_ring_pattern import fit_ring_pattern
from palpate.vision.pattern import MarkerPattern, PatternFit, wrap_deg

_CHANCE = 5e-3
"""Maximum probability of all other symmetries for the mark to decide. By hand."""
_MARK_REACH = 3.0
"""Maximum distance of the mark from its predicted position, in standard deviations. By hand."""
_SEEN = 20.0
"""Prior of the share of hidden blobs: number of prints of one blob, of which one is hidden. By hand."""
_MIRROR = 0.05
"""Prior share of cameras that mirror the image. By hand."""
_LEAST_SHARE = 0.55
"""Minimum share of markers with a blob. By hand."""


@dataclass(frozen=True, eq=False)
class MarkerAssignment:
    """Assignment of blobs to markers.

    Attributes
    ----------
    blob
        (m,) index of the blob of each marker, -1 without one.
    positions_px
        (m, 2) pixels of the blob, or the position predicted by the fitted map.
    found
        (m,) whether a blob was assigned.
    turn_deg, mirrored
        Rotation (from column to row) and mirroring of the pattern in the image, relative to the nominal camera.
    alternatives
        Equally good assignments, themselves without alternatives; empty if unique.
    mark
        Index of the blob that is the orientation mark, -1 if not found.
    residual_px
        Root mean square distance of the blobs from the fitted map.
    """

    blob: NDArray[np.intp]
    positions_px: FloatArray
    found: BoolArray
    turn_deg: float
    mirrored: bool
    alternatives: tuple[MarkerAssignment, ...]
    mark: int
    residual_px: float

    @property
    def ambiguous(self) -> bool:
        """Whether other assignments fit equally well."""
        return len(self.alternatives) > 0


def assign_markers(blobs_px: FloatArray, pattern: MarkerPattern) -> MarkerAssignment:
    """Assign the blobs of a rest image, centres (n, 2) px, to the markers of a pattern.

    Some blobs may be missing or false.

    Raises
    ------
    PalpateError
        If too few markers have a blob, or the assignment is doubtful: another design, or not at rest.
    """
    blobs_px = np.asarray(blobs_px, float).reshape(-1, 2)
    rings = pattern.rings
    laid = fit_ring_pattern(blobs_px, pattern, rings) if rings is not None else fit_free_pattern(blobs_px, pattern)
    count = laid.count if laid else 0
    if laid is None or laid.doubt or count < max(3, _LEAST_SHARE * len(pattern)):
        why = f": {laid.doubt}" if laid and laid.doubt else ""
        raise PalpateError(
            f"{count} of {len(pattern)} markers were found among {len(blobs_px)} blobs{why}.",
            "Check that design and camera are those of the image, and that the skin is unloaded.",
            code="assignment-doubtful" if why else "markers-not-assigned",
        )
    return _resolve(blobs_px, pattern, laid)


def _resolve(blobs: FloatArray, pattern: MarkerPattern, laid: PatternFit) -> MarkerAssignment:
    """Choose among equivalent symmetries by the mark; without it, sort them by rotation as alternatives."""
    blob = laid.blob
    expected = np.where(blob[:, None] >= 0, blobs[blob], laid.places_px)
    turn = _turn_deg(pattern.expected_px * [1.0, -1.0 if laid.mirrored else 1.0], laid.places_px)
    choices, mark = _find_mark(blobs, pattern, laid)
    # the pattern moved by a symmetry fits as well: the whole then is turned by as much less
    turns = wrap_deg(turn + pattern.turns_deg[choices])
    namings = []
    for rank in np.lexsort([np.abs(turns), pattern.mirrored[choices]]):
        # the dot at the place of marker i is marker order[i]
        order = np.argsort(pattern.symmetries[choices[rank]])
        namings.append(
            MarkerAssignment(
                blob=blob[order],
                positions_px=expected[order],
                found=blob[order] >= 0,
                turn_deg=float(turns[rank]),
                mirrored=bool(pattern.mirrored[choices[rank]] != laid.mirrored),
                alternatives=(),
                mark=mark,
                residual_px=laid.residual_px,
            )
        )
    return replace(namings[0], alternatives=tuple(namings[1:]))


def _turn_deg(template: FloatArray, places: FloatArray) -> float:
    """Return the angle of the rotation that best aligns the template (m, 2) with the places (m, 2)."""
    a, b = template - template.mean(axis=0), places - places.mean(axis=0)
    across = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
    return float(np.degrees(np.arctan2(across, (a * b).sum())))


def _find_mark(blobs: FloatArray, pattern: MarkerPattern, laid: PatternFit) -> tuple[NDArray[np.intp], int]:
    """Return the symmetries that agree with the orientation mark, and its blob; all and -1 if undecided.

    The mark is a blob that belongs to no marker. Under a symmetry, it is either near its predicted position or
    hidden; unassigned blobs are uniformly distributed. One symmetry is accepted if all others together have a
    probability below `_CHANCE`.
    """
    every = np.arange(len(pattern.symmetries))
    free = np.setdiff1d(np.arange(len(blobs)), laid.blob[laid.blob >= 0])
    if laid.marks_px is None or laid.mark_axes_px is None or not len(free):
        return every, -1
    away = (blobs[free][None] - laid.marks_px[:, None]) @ np.linalg.inv(laid.mark_axes_px)
    square = (away**2).sum(axis=-1)
    hidden = (1.0 + (laid.blob < 0).sum()) / (_SEEN + len(laid.blob))
    crowd = (len(free) + 1) / float(np.prod(np.ptp(blobs, axis=0)))
    area = 2.0 * np.pi * np.abs(np.linalg.det(laid.mark_axes_px))
    near = np.where(square < _MARK_REACH**2, np.exp(-square / 2.0), 0.0)
    odds = hidden + (1.0 - hidden) * near / (crowd * area)[:, None]
    odds *= np.where(pattern.mirrored != laid.mirrored, _MIRROR, 1.0)[:, None]
    best, dot = np.unravel_index(np.argmax(odds), odds.shape)
    likely = odds.max(axis=1)
    likely /= likely.sum()
    if 1.0 - likely[best] < _CHANCE and near[best, dot] > 0.0:
        return np.array([best]), int(free[dot])
    return every, -1
