"""Polarity and size of the markers, from one image.

All sizes and polarities are tried, on a reduced image for large markers. In a clean image, the best field has the
most blobs of equal size and contrast and the fewest other blobs. In front of a cluttered background no size is clean;
the markers are then recognised by their regularity: in a printed field most blobs lie midway between two neighbours,
of random blobs one in eleven.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray
from palpate.vision.opencv import blur
from palpate.vision.segment import MEDIAN_SD, Blobs, Segments, heights, measure_noise, segment
from palpate.vision.spec import DetectSpec

Image = NDArray[np.float32]
_SIZES_PX = tuple(4.0 * 1.35**k for k in range(12))
"""Diameters that are tried; a field is found at diameters within a third of its own."""
_CLEAN, _MANY, _LEAST = 0.45, 12, 6
"""Limits of a clean field: minimum share of the area of all blobs, and number, of its similar blobs.

The last value is the minimum number of blobs of any field. Real fields (`docs/sensor.md`) have shares of 0.51 to
0.99, a skin with a bright rim and surrounding clutter 0.2 to 0.8. Clutter without a field has 0.2 to 0.7, but no
regularity. By hand.
"""
_HALF = 0.8
"""Minimum fullness of a blob: a disc has 1, two touching discs 0.9, a ring 0.7."""
_NEIGHBOURS, _HALF_WAY = 6, 0.15
"""Number of neighbours; maximum sum of the arms to two of them, over the mean length of the two arms.
By hand."""
AT_RANDOM = 0.092
"""Share of random blobs midway between two of their neighbours (measured, 40 fields of 60)."""
_ORDERED = 2.5
"""Standard deviations of regularity by which a regular field must exceed the cleanest one. By hand."""
_ROUND, _FULL, _ALIKE = 0.65, 0.9, 0.5
"""Regular blobs: minimum axis ratio and fullness, maximum log ratio to the tried size. By hand."""

_IN_ORDER, _ABOVE_CHANCE = 0.25, 5.0
"""Minimum share of midpoint blobs of a regular field, and its excess in standard deviations.

Public images of markers have 0.32 and 6.0 or more, except one with similar blobs; grain has up to 0.2. By hand.
"""
_DISTINCT = 30.0
"""Minimum contrast over pixel noise, times diameter in px; a faint weave has less, faint markers 44.
By hand."""
_AT_BORDER, _NOT_LONG = 0.25, 0.59
"""Maximum share of blobs at the image border, and minimum median axis ratio.

A weave extends beyond the image, and its pieces are long; public images have at most 0.08 and at least 0.69. By hand.
"""
_ONE_WAY = 0.7
"""Maximum alignment of the arms between neighbours with one direction. By hand."""
_DISC = 0.95
"""Median axis ratio above which blobs are discs and not threads, whatever their alignment. By hand."""
_EQUAL, _FEWEST, _OVAL = 0.06, 8, 0.75
"""Similar blobs: maximum spread of log contrast, minimum number, minimum median axis ratio.

Up to seven lamps around a skin are as similar as printed markers. By hand.
"""


@dataclass(frozen=True)
class FieldCandidate:
    """Field of similar blobs of one polarity and size (their median diameter) in an image.

    `clean` is their share of the area of all blobs, `score` is 0 if rejected, `roundness` their median axis ratio.
    """

    dark: bool
    diameter_px: float
    dots: int
    clean: float
    score: float
    roundness: float = 0.0


def choose_fields(grey: Image, spec: DetectSpec) -> Iterator[FieldCandidate]:
    """Return the cleanest and the most regular field of grey levels (h, w), the better one first."""
    tries = [
        (dark, size)
        for dark in ([True, False] if spec.polarity == "auto" else [spec.polarity == "dark"])
        for size in ((spec.diameter_px,) if spec.diameter_px else _SIZES_PX)
        if size < min(grey.shape) / 3
    ]
    fields = [_evaluate(grey, dark, size, spec) for dark, size in tries]
    best = max(fields, key=lambda field: field.score, default=None)
    if best is None:
        return
    if sure := best.dots >= _MANY and best.clean >= _CLEAN:
        yield best
    ordered = [_order(grey, dark, size, spec) for dark, size in tries]
    first = int(np.argmax([field.score for field in ordered]))
    if ordered[first].score > max(ordered[fields.index(best)].score, 0.0) + _ORDERED:
        yield ordered[first]
    known = spec.diameter_px is not None and spec.polarity != "auto"
    if not sure and best.score > 0.0 and (best.dots >= _LEAST or known):
        yield best


def choose_dots(segments: Segments, diameter_px: float, spec: DetectSpec) -> NDArray[np.intp]:
    """Return indices of the candidates that look like markers by size, roundness, fullness and contrast."""
    size = segments.diameter_px / diameter_px
    good = (size > 0.4) & (size < 2.2) & (segments.roundness > spec.roundness) & (segments.fullness > _HALF)
    good &= (segments.area_px >= 4) | segments.at_border
    for values in (segments.contrast, segments.diameter_px):
        if good.any():
            good &= values > spec.evenness * float(np.median(values[good]))
    return np.flatnonzero(good)


def _cut(grey: Image, dark: bool, size: float, spec: DetectSpec) -> tuple[Segments, int]:
    """Return the candidates of one size, and the reduction factor of the image."""
    step = int(max(1, size // 8))
    if step > 1:
        grey = blur(grey, 0.5 * step)[::step, ::step]
    height, factor = heights(grey if dark else -grey, size / step)
    return segment(height, size / step, spec.threshold * measure_noise(grey) * factor, spec.evenness), step


def _evaluate(grey: Image, dark: bool, size: float, spec: DetectSpec) -> FieldCandidate:
    """Evaluate the cleanness of the field of one size."""
    segments, step = _cut(grey, dark, size, spec)
    chosen = choose_dots(segments, size / step, spec)
    if len(chosen) < 3:
        return FieldCandidate(dark, size, 0, 0.0, 0.0)
    diameter, contrast = segments.diameter_px[chosen], segments.contrast[chosen]
    typical = float(np.median(diameter))
    alike = _are_alike(diameter, contrast)
    area = float((diameter[alike] ** 2).sum()) / float((segments.diameter_px**2).sum())
    fit = np.exp(-(np.log(typical * step / size) ** 2) / 0.18)
    score = alike.sum() * np.sqrt(typical * step) * area**2 * fit * np.sqrt(np.median(contrast))
    round_ = float(np.median(segments.roundness[chosen]))
    return FieldCandidate(dark, typical * step, int(alike.sum()), area, float(score), round_)


def _are_alike(diameter: FloatArray, contrast: FloatArray) -> BoolArray:
    """Return whether each blob (n,) has about the median diameter and contrast."""
    similar = np.abs(np.log(diameter / np.median(diameter))) < 0.4
    return np.asarray(similar & (np.abs(np.log(contrast / np.median(contrast))) < 0.7))


def _order(grey: Image, dark: bool, size: float, spec: DetectSpec) -> FieldCandidate:
    """Evaluate the regularity of the blobs of one size, in standard deviations above random blobs."""
    segments, step = _cut(grey, dark, size, spec)
    chosen = choose_dots(segments, size / step, spec)
    diameter = segments.diameter_px * step
    good = (segments.roundness > _ROUND) & (segments.fullness > _FULL) & (np.abs(np.log(diameter / size)) < _ALIKE)
    chosen = chosen[good[chosen]]
    if len(chosen) < _LEAST:
        return FieldCandidate(dark, size, len(chosen), 0.0, 0.0)
    between = is_midpoint(segments.middle_px[chosen])
    above = between.sum() - AT_RANDOM * len(chosen)
    score = above / np.sqrt(len(chosen) * AT_RANDOM * (1.0 - AT_RANDOM))
    typical = float(np.median(diameter[chosen][between])) if between.any() else size
    round_ = float(np.median(segments.roundness[chosen]))
    return FieldCandidate(dark, typical, len(chosen), float(between.mean()), float(score), round_)


def is_midpoint(points: FloatArray) -> BoolArray:
    """Return whether each point (n, 2) lies midway between two of its nearest neighbours."""
    if len(points) < 3:
        return np.zeros(len(points), bool)
    return np.asarray((_arms(points)[1] < _HALF_WAY / 2.0).any(axis=(1, 2)))


def _arms(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return arms (n, k, 2) to neighbours, and lengths (n, k, k) of sums of two arms over their lengths."""
    distance, number = cKDTree(points).query(points, min(_NEIGHBOURS + 1, len(points)))
    arms, length = points[number[:, 1:]] - points[:, None], distance[:, 1:]
    lengths = np.maximum(length[:, :, None] + length[:, None], 1e-9)
    return arms, np.linalg.norm(arms[:, :, None] + arms[:, None], axis=-1) / lengths


def is_printed(blobs: Blobs, field: FieldCandidate) -> bool:
    """Return whether blobs of an image, found by a field, look printed."""
    count = len(blobs)
    if count < _FEWEST or blobs.at_border.mean() > _AT_BORDER or field.roundness < _NOT_LONG:
        return False
    contrast = np.maximum(blobs.contrast, 1e-9)
    clear = float(np.median(blobs.contrast)) / blobs.noise * float(np.median(blobs.diameter_px)) > _DISTINCT
    similar = blobs.positions_px[_are_alike(blobs.diameter_px, contrast)]
    in_order = _are_in_order(blobs.positions_px) or _are_in_order(similar)
    alike = _spread(np.log(contrast)) < _EQUAL and field.roundness > _OVAL
    one_way = field.roundness < _DISC and _in_one_direction(blobs.positions_px) > _ONE_WAY
    return bool(clear and not one_way and (in_order or alike))


def _are_in_order(points: FloatArray) -> bool:
    """Return whether more points (n, 2) lie midway between two neighbours than of random ones."""
    share = float(is_midpoint(points).mean()) if len(points) else 0.0
    above = (share - AT_RANDOM) * np.sqrt(len(points) / (AT_RANDOM * (1.0 - AT_RANDOM)))
    return bool(share > _IN_ORDER and above > _ABOVE_CHANCE)


def _in_one_direction(points: FloatArray) -> float:
    """Return the alignment of the straightest arms: 1 for threads of a weave, near 0 for grids and rings."""
    arms, miss = _arms(points)
    best = miss.reshape(len(points), -1).argmin(axis=1) // arms.shape[1]
    arm = arms[np.arange(len(points)), best]
    return float(np.abs(np.mean(np.exp(2j * np.arctan2(arm[:, 1], arm[:, 0])))))


def _spread(values: FloatArray) -> float:
    """Return the standard deviation estimated from the median absolute deviation."""
    return float(MEDIAN_SD * np.median(np.abs(values - np.median(values))))
