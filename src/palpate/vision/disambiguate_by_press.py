"""Resolution of an ambiguous assignment by an image of one press of known pose.

Rings of markers are symmetric under rotation by 60° and mirroring; a tilted wall is not. Each assignment predicts
another motion of every blob. The blobs are found again in the pressed image, and the assignment with the nearest
motion is chosen. The depth of the press may be wrong, as a robot's is: each motion is scaled for its best fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import FloatArray, PalpateError
from palpate.vision.assign_markers import MarkerAssignment
from palpate.vision.tracker import REACH

_GAINS = np.linspace(0.5, 1.5, 15)
"""Factors on the motion: 1 mm of error of first contact at 4 mm depth is a quarter."""
_CANDIDATES, _ROUNDS = 0.8, 3
"""Share of markers used in the first comparison, as some may be lost; number of fits. By hand."""
_STRAY, _STRAY_PX = 4.0, 0.5
"""Maximum distance of a blob from its prediction, over the median distance, if more than these pixels.
By hand."""
_APART_PX = 0.12
"""Root mean square difference of two motions below which the press does not distinguish them. By hand."""
_SURE = 0.2
"""Minimum of `PressFit.sureness` for an assignment to be ruled out; 0.5 is the maximum. By hand."""
_EXPLAINED = 0.35
"""Maximum misfit of the best assignment over the motion, for a press of this pose. By hand."""
_LEAST_MOTION_PX = 1.0
"""Minimum motion of a press that is compared. By hand."""


@dataclass(frozen=True, eq=False)
class PressFit:
    """Agreement of each assignment with a reference press.

    Attributes
    ----------
    naming
        The best assignment; its alternatives agree about equally well.
    misfit_px
        (k,) root mean square distance of the blobs from their predictions, in the order of the ambiguous assignment
        and its alternatives.
    sureness
        (k,) position of the blobs between the motion of each assignment (-0.5) and that of the best one (0.5).
    gain
        Fitted factor on the motion of the best assignment; far from 1 if the depth was different.
    """

    naming: MarkerAssignment
    misfit_px: FloatArray
    sureness: FloatArray
    gain: float


def disambiguate_by_press(
    naming: MarkerAssignment, motions_px: FloatArray, pressed_px: FloatArray, spacing_px: float
) -> PressFit:
    """Choose among the assignments that fit a rest image.

    Parameters
    ----------
    naming
        Ambiguous assignment of a rest image.
    motions_px
        (k, m, 2) simulated motion of every marker in the image, under the assignment and each alternative.
    pressed_px
        (n, 2) blobs in an image of the press by the same camera, in any order.
    spacing_px
        Minimum distance of two markers at rest.

    Returns
    -------
    PressFit
        Its assignment is still ambiguous if several agree about equally well, as for a wall without tilt.

    Raises
    ------
    PalpateError
        If the press hardly moves the markers, or no assignment explains the motion: another pose.
    """
    choices = (replace(naming, alternatives=()), *naming.alternatives)
    moved = float(np.sqrt(np.mean((motions_px**2).sum(axis=-1))))
    if not moved > _LEAST_MOTION_PX:
        raise PalpateError(
            f"The reference press moves the markers by {moved:.2f} px only.",
            "Press deeper, with a tilted wall.",
            code="reference-press-too-light",
        )
    motions = np.stack([_by_dot(choice, motion) for choice, motion in zip(choices, motions_px, strict=True)])
    rest = _by_dot(naming, naming.positions_px)
    pressed_px = np.asarray(pressed_px, float).reshape(-1, 2)
    reach = REACH * spacing_px
    best, gain = _begin(rest, motions, pressed_px, reach)
    for _ in range(_ROUNDS):
        seen = _match(rest + gain * motions[best], pressed_px, reach) - rest
        have = np.asarray(np.isfinite(seen).all(axis=1))
        gains = _gains(seen[have], motions[:, have])
        laid = motions[:, have] * gains[:, None, None]
        misfit = np.sqrt(((seen[have] - laid) ** 2).sum(axis=(1, 2)) / max(have.sum(), 1))
        best = int(np.argmin(misfit))
        gain = float(gains[best])
    if misfit[best] > _EXPLAINED * moved or have.mean() < _CANDIDATES / 2.0:
        raise PalpateError(
            f"No assignment explains the press: {have.sum()} of {len(have)} markers have a blob, with a residual of "
            f"{misfit[best]:.1f} px.",
            "Check its roll, pitch and depth, and that camera and skin have not moved since the rest image.",
            code="reference-press-unexplained",
        )
    apart = ((laid - laid[best]) ** 2).sum(axis=(1, 2)) / have.sum()
    sureness = (misfit**2 - misfit[best] ** 2) / np.maximum(2.0 * apart, 1e-12)
    alike = np.flatnonzero((sureness < _SURE) | (apart < _APART_PX**2))
    others = tuple(choices[number] for number in alike if number != best)
    return PressFit(replace(choices[best], alternatives=others), misfit, sureness, gain)


def _by_dot(choice: MarkerAssignment, values: FloatArray) -> FloatArray:
    """Return values (n, 2) of the found markers in the order of their blobs, common to all assignments."""
    return np.asarray(values[choice.found][np.argsort(choice.blob[choice.found])])


def _begin(rest: FloatArray, motions: FloatArray, pressed: FloatArray, reach: float) -> tuple[int, float]:
    """Return the assignment, and the factor on its motion, whose markers are nearest to blobs."""
    if not len(pressed):
        return 0, 1.0
    tree, kept = cKDTree(pressed), max(int(_CANDIDATES * len(rest)), 1)
    best = (np.inf, 0, 1.0)
    for number, motion in enumerate(motions):
        for gain in _GAINS:
            distance = np.minimum(tree.query(rest + gain * motion)[0], reach)
            best = min(best, (float((np.sort(distance)[:kept] ** 2).sum()), number, float(gain)))
    return best[1:]


def _match(expected: FloatArray, pressed: FloatArray, reach: float) -> FloatArray:
    """Return the blob (n, 2) of each marker; NaN if none is near enough."""
    if not len(pressed):
        return np.full_like(expected, np.nan)
    distance, dot = cKDTree(pressed).query(expected)
    near = distance < min(reach, max(_STRAY * float(np.median(distance)), _STRAY_PX))
    return np.where(near[:, None], pressed[dot], np.nan)


def _gains(seen: FloatArray, motions: FloatArray) -> FloatArray:
    """Return the best-fitting factor (k,) on the motion (k, n, 2) of each assignment, within bounds."""
    gains = (motions * seen).sum(axis=(1, 2)) / np.maximum((motions**2).sum(axis=(1, 2)), 1e-12)
    return np.asarray(np.clip(gains, _GAINS[0], _GAINS[-1]))
