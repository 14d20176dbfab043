"""Validation of the rings found among blobs: completeness, and the number of false alarms."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.vision.find_rings_by_structure import RingFinder, mark_turns
from palpate.vision.fit_ring import MARK_PX
from palpate.vision.pattern import MarkerPattern, PatternFit
from palpate.vision.ring_model import BENT, TWIST, RingFit, RingsFit, extrapolate_ring, fit_ring_model
from palpate.vision.rings import Rings, ring_harmonics

_CHANCE = -7.5
"""Maximum log10 of the number of false alarms of a print. By hand."""
_BEYOND = 0.6
"""Share of the places of one additional ring at which the print is of another design. By hand."""
_RIVAL = 2.0
"""Minimum lead over a print of another centre, in powers of ten. By hand."""
_STRANGE, _STRANGE_SHARE = 12, 0.1
"""Maximum number of unassigned blobs inside the print: constant, and per assigned blob. By hand."""
_DOT_MM, _DOT_BELIEF = 0.06, 6
"""Prior standard deviation of each coordinate of a printed marker, and its weight in blobs. By hand."""
_ASIDE_MM = 0.1
"""Standard deviation of the offset of a whole print from the axis, in each direction. By hand."""
_MARK_STRETCH, _MARK_BENT = 0.02, 0.06
"""Radial standard deviation of the mark over its distance from the outermost ring.

The values are those of an even print, and the increase for a distorted one. By hand.
"""


def fit_ring_pattern(blobs_px: FloatArray, pattern: MarkerPattern, rings: Rings) -> PatternFit | None:
    """Fit the rings of the pattern to blobs (n, 2); `None` without an innermost ring."""
    if len(np.unique(blobs_px, axis=0)) < 4:
        return None
    finder = RingFinder(blobs_px, pattern, rings)
    found = finder.find()
    if not found:
        return None
    best = found[0]
    blob = np.full(len(pattern), -1)
    places = np.full((len(pattern), 2), np.nan)
    for number, ring in enumerate(best.rings):
        members = rings.members(number)
        blob[members] = ring.blob
        places[members] = ring_harmonics(rings.azimuth[members], 7) @ ring.weights
    marks, axes = _marks(best, pattern, finder)
    doubt = _doubt(finder, found)
    return PatternFit(blob, places, best.residual_px, False, marks, axes, doubt)


def _doubt(finder: RingFinder, found: list[RingsFit]) -> str:
    """Return the reason to doubt the best fit, or an empty string."""
    best, rings = found[0], finder.rings
    if len(best.rings) <= len(rings):
        return f"ring {len(best.rings)} of {len(rings)} was not found"
    chance = best.power + float(np.log10(max(finder.seeds, 1)))
    if chance > _CHANCE:
        return f"random blobs would fit as well in 1 of {10.0 ** -min(chance, 0.0):.0f} images"
    uneven = [number for number, ring in enumerate(best.rings) if number and not ring.even and ring.count]
    if uneven:
        return f"ring {uneven[0]} is uneven: the residual of its blobs is {best.rings[uneven[0]].residual_px:.1f} px"
    if len(best.rings) > 2 and np.abs(best.twist).max() > TWIST:
        which = int(np.argmax(np.abs(best.twist)))
        return f"ring {which + 2} is rotated by {best.twist[which]:.1f} of its steps against the ring inside"
    if best.crossing:
        return f"rings {best.crossing - 1} and {best.crossing} cross"
    more, there = finder.beyond(best)
    if there > _BEYOND * more:
        return f"one more ring of {more} has {there} blobs"
    if unsure := finder.first_unreliable_ring(best):
        return f"ring {unsure} has few blobs, and a false one is near one of its empty places"
    if lopsided := finder.first_distorted_ring(best):
        return f"ring {lopsided} is distorted: one of its blobs does not lie on the ellipse of the remaining ones"
    strange = finder.count_unassigned(best)
    if strange > _STRANGE + _STRANGE_SHARE * best.count:
        return f"{strange} other blobs lie between them"
    if len(rings) == 1 and finder.other is not None and finder.other.power < best.power + 0.5 * _RIVAL:
        return "its only ring fits other blobs as well"
    if len(found) > 1 and found[1].power < best.power + _RIVAL:
        return f"around another centre {found[1].count} fit as well"
    return ""


def _marks(fit: RingsFit, pattern: MarkerPattern, finder: RingFinder) -> tuple[FloatArray | None, FloatArray | None]:
    """Predict the orientation mark under each symmetry, with the axes of its standard deviations."""
    if pattern.marks_px is None or pattern.mark is None or len(fit.rings) <= len(finder.rings):
        return None, None
    outer, turns = fit.rings[-1], mark_turns(pattern)
    law = fit_ring_model(fit.rings[1:], finder.profile, finder.nominal_px[1:], finder.rings.rho[1:])
    weights, doubt, aside = extrapolate_ring(law, outer, (finder.rings.rho[-1], float(np.hypot(*pattern.mark[:2]))))
    places = ring_harmonics(turns, 7) @ weights
    out = places - weights[0]
    length = np.linalg.norm(out, axis=1, keepdims=True)
    out /= length
    factor = law.rho / finder.rings.rho[1:]
    bent = min(float(np.abs(factor - 1.0).max()) / BENT, 1.0) if len(factor) > 1 else 1.0
    outside = float(length.mean()) - outer.radius_px
    scale = law.zoom * float(finder.profile.scale(np.hypot(*pattern.mark[:2])))
    along = np.hypot(max(MARK_PX, _scatter(outer, scale * _DOT_MM)), aside)
    stretch = (_MARK_STRETCH + bent * _MARK_BENT) * outside
    shift = _ASIDE_MM * law.steeper(outer.radius_px, float(length.mean()))
    far = float(np.sqrt(along**2 + stretch**2 + (bent * doubt) ** 2 + shift**2))
    axes = np.stack([far * out, along * np.stack([-out[:, 1], out[:, 0]], axis=-1)], axis=1)
    return places, axes


def _scatter(ring: RingFit, expected_px: float) -> float:
    """Return the standard deviation (px) of a coordinate of one more blob about a fitted ring.

    The prior `expected_px` has the weight of `_DOT_BELIEF` blobs.
    """
    unknowns = len(ring.weights)
    left = float(np.nansum(ring.error_px**2)) / 2.0 + _DOT_BELIEF * expected_px**2
    square = left / (max(ring.count - unknowns, 0) + _DOT_BELIEF)
    return float(np.sqrt(square * (1.0 + unknowns / max(ring.count, 1))))
