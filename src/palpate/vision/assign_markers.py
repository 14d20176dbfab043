"""Assignment of dots at rest to markers (naming), for a camera and a print that are not known well.

1. Rings are found by their structure: their numbers of dots, their order, their common azimuth
   (`palpate.vision.find_rings_by_structure`); free layouts by their neighbourhoods
   (`palpate.vision.fit_free_pattern`).
2. What is doubtful is refused: a ring that is not there, one more than there should be, rings turned against each
   other, or what dots strewn at random would show.
3. A layout of rings looks the same turned by 60° and in a mirror. The orientation mark tells these apart; without it
   the numbers are given for the smallest turn and marked as ambiguous.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.vision.fit_free_pattern import fit_free_pattern
from palpate.vision.fit_ring_pattern import fit_ring_pattern
from palpate.vision.pattern import MarkerPattern, PatternFit

_CHANCE = 5e-3
"""Chance that another symmetry is the right one, above which the mark is not believed."""
_MARK_REACH = 3.0
"""A dot is not the mark this many standard deviations from its place."""
_SEEN = 20.0
"""Prints of one dot, one of them hidden, that are known beforehand."""
_MIRROR = 0.05
"""Share of the cameras that mirror the image."""
_LEAST_SHARE = 0.55
"""Share of the markers that must be found for a naming to be believed."""


@dataclass(frozen=True, eq=False)
class MarkerAssignment:
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
    alternatives: tuple[MarkerAssignment, ...]
    mark: int
    residual_px: float

    @property
    def ambiguous(self) -> bool:
        """Whether other namings fit as well."""
        return len(self.alternatives) > 0


def assign_markers(blobs_px: FloatArray, pattern: MarkerPattern) -> MarkerAssignment:
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
        If too few markers find a dot, or it is doubtful that they are the design's: another design, or not at rest.
    """
    blobs_px = np.asarray(blobs_px, float).reshape(-1, 2)
    rings = pattern.rings
    laid = fit_ring_pattern(blobs_px, pattern, rings) if rings is not None else fit_free_pattern(blobs_px, pattern)
    count = laid.count if laid else 0
    if laid is None or laid.doubt or count < max(3, _LEAST_SHARE * len(pattern)):
        why = f": {laid.doubt}" if laid and laid.doubt else ""
        raise PalpateError(
            f"{count} of {len(pattern)} markers were found among {len(blobs_px)} dots{why}.",
            "Check that design and camera are those of the image, and that the dome is at rest.",
            code="assignment-doubtful" if why else "markers-not-assigned",
        )
    return _resolve(blobs_px, pattern, laid)


def _resolve(blobs: FloatArray, pattern: MarkerPattern, laid: PatternFit) -> MarkerAssignment:
    """Choose among the turns and mirrors that fit as well: by the mark, else the smallest turn, and say so."""
    blob = laid.blob
    expected = np.where(blob[:, None] >= 0, blobs[blob], laid.places_px)
    turn = _turn_deg(pattern.expected_px * [1.0, -1.0 if laid.mirrored else 1.0], laid.places_px)
    choices, mark = _find_mark(blobs, pattern, laid)
    # the pattern moved by a symmetry fits as well: the whole then is turned by as much less
    turns = (turn + pattern.turns_deg[choices] + 180.0) % 360.0 - 180.0
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
    """Angle of the turn that brings the template (m, 2) nearest to the places (m, 2)."""
    a, b = template - template.mean(axis=0), places - places.mean(axis=0)
    across = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()
    return float(np.degrees(np.arctan2(across, (a * b).sum())))


def _find_mark(blobs: FloatArray, pattern: MarkerPattern, laid: PatternFit) -> tuple[NDArray[np.intp], int]:
    """Numbers of the symmetries that the orientation mark leaves, and its dot: -1 where it does not decide.

    The mark is a dot that belongs to no marker. Under a symmetry, either it lies where the print's law expects it, or
    it is hidden; other dots lie anywhere. One symmetry is believed where all others together are less likely than
    `_CHANCE`.
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
