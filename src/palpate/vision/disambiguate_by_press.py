"""From numbers that are ambiguous at rest to one numbering, by an image of a press whose pose is known.

Rings of dots look the same turned by 60° and in a mirror; a slanted wall does not. Under each numbering every dot
should move in its own way. The dots are found again in the pressed image, and the numbering whose motion is nearest
to theirs is taken. The depth of the press may be off, as a robot's is: each motion is scaled for its best fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import FloatArray, PalpateError
from palpate.vision.assign_markers import MarkerAssignment

_GAINS = np.linspace(0.5, 1.5, 15)
"""Factors on the motion: a touch point 1 mm off at 4 mm depth is a quarter."""
_REACH = 0.45
"""Distance to the nearest dot that may be the marker's, over the spacing of the markers at rest."""
_CANDIDATES, _ROUNDS = 0.8, 3
"""Share of the markers by which motions are compared at first, as some may be lost; turns of the fit."""
_STRAY, _STRAY_PX = 4.0, 0.5
"""A dot this many times the median from where the best numbering expects it, and this far, is another's."""
_APART_PX = 0.12
"""Root mean square distance of the motions of two numberings below which the press does not tell them apart."""
_SURE = 0.2
"""How much nearer to one motion than to the other the dots must lie, over the distance of both; 0.5 is all of it."""
_EXPLAINED = 0.35
"""Greatest misfit of the best numbering over the motion: above it the press is not the one that was given."""
_LEAST_MOTION_PX = 1.0
"""Smallest motion of a press that is compared."""


@dataclass(frozen=True, eq=False)
class PressFit:
    """How well each numbering agrees with a known press.

    Attributes
    ----------
    naming
        The best numbering; its alternatives are those that agree about equally.
    misfit_px
        (k,) root of the mean squared distance of the dots from where each numbering expects them, in the order of the
        ambiguous naming and its alternatives.
    sureness
        (k,) where the dots lie on the way from the motion of each numbering (-0.5) to that of the best one (0.5).
    gain
        Factor on the motion for which the best numbering fits: far from 1, the depth was another.
    """

    naming: MarkerAssignment
    misfit_px: FloatArray
    sureness: FloatArray
    gain: float


def disambiguate_by_press(
    naming: MarkerAssignment, motions_px: FloatArray, pressed_px: FloatArray, spacing_px: float
) -> PressFit:
    """Choose among the numberings that fit the image at rest.

    Parameters
    ----------
    naming
        The ambiguous naming of an image at rest.
    motions_px
        (k, m, 2) how every marker should move in the image, by simulation, under the naming and each alternative.
    pressed_px
        (n, 2) dots in an image of the press by the same camera, in any order.
    spacing_px
        Least distance of two markers at rest.

    Returns
    -------
    PressFit
        Its naming is ambiguous still where several numberings agree about equally, as for a straight wall.

    Raises
    ------
    PalpateError
        If the press should hardly move the markers, or no numbering explains what moved: another pose.
    """
    choices = (replace(naming, alternatives=()), *naming.alternatives)
    moved = float(np.sqrt(np.mean((motions_px**2).sum(axis=-1))))
    if not moved > _LEAST_MOTION_PX:
        raise PalpateError(
            f"The known press moves the markers by {moved:.2f} px only.",
            "Press deeper, by a slanted wall.",
            code="reference-press-too-light",
        )
    motions = np.stack([_by_dot(choice, motion) for choice, motion in zip(choices, motions_px, strict=True)])
    rest = _by_dot(naming, naming.positions_px)
    pressed_px = np.asarray(pressed_px, float).reshape(-1, 2)
    reach = _REACH * spacing_px
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
            f"No numbering explains the press: {have.sum()} of {len(have)} markers found their dot, "
            f"{misfit[best]:.1f} px off.",
            "Check its roll, pitch and depth, and that camera and dome are where they were at rest.",
            code="reference-press-unexplained",
        )
    apart = ((laid - laid[best]) ** 2).sum(axis=(1, 2)) / have.sum()
    sureness = (misfit**2 - misfit[best] ** 2) / np.maximum(2.0 * apart, 1e-12)
    alike = np.flatnonzero((sureness < _SURE) | (apart < _APART_PX**2))
    others = tuple(choices[number] for number in alike if number != best)
    return PressFit(replace(choices[best], alternatives=others), misfit, sureness, gain)


def _by_dot(choice: MarkerAssignment, values: FloatArray) -> FloatArray:
    """(n, 2) values of the found markers in the order of their dots, which is the same under every numbering."""
    return np.asarray(values[choice.found][np.argsort(choice.blob[choice.found])])


def _begin(rest: FloatArray, motions: FloatArray, pressed: FloatArray, reach: float) -> tuple[int, float]:
    """The numbering and the factor on its motion whose markers lie nearest to dots."""
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
    """(n, 2) the dot of each marker; NaN where there is none, or another marker's."""
    if not len(pressed):
        return np.full_like(expected, np.nan)
    distance, dot = cKDTree(pressed).query(expected)
    near = distance < min(reach, max(_STRAY * float(np.median(distance)), _STRAY_PX))
    return np.where(near[:, None], pressed[dot], np.nan)


def _gains(seen: FloatArray, motions: FloatArray) -> FloatArray:
    """(k,) factor on the motion (k, n, 2) of each numbering that fits what was seen (n, 2) best, within bounds."""
    gains = (motions * seen).sum(axis=(1, 2)) / np.maximum((motions**2).sum(axis=(1, 2)), 1e-12)
    return np.asarray(np.clip(gains, _GAINS[0], _GAINS[-1]))
