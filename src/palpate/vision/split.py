"""Separation of two merged blobs, recognised by area, length and a waist.

Two equal discs of radius R at a distance d have the variances R²/4 + d²/4 along and R²/4 across, so the blob's own
moments give d = 2 √(v₁ - v₂). A long single blob has no waist: it is widest in the middle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray
from palpate.vision.segment import Segments

Image = NDArray[np.float32]
_LEAST_AREA, _LARGEST_AREA = 1.4, 2.6
"""Area of the blob over that of the median one: two discs without their intersection."""
_ROUNDEST = 0.75
"""Axis ratio above which a blob is single: two discs half a diameter apart have 0.71."""
_WAIST = 0.9
"""Maximum height summed across the middle, over that across the two centres. By hand."""
_MARGIN_PX = 3
"""Margin around the blob that goes to the nearer centre, not to the second fit. By hand."""
_BETWEEN_PX = 1.0
"""Half width of the strip between two parts that blur into each other. By hand."""


def split_merged(segments: Segments, height: Image, wanted: BoolArray) -> Segments:
    """Split every wanted (n,) candidate that consists of two blobs, by the image of heights (h, w).

    Return the same object if nothing is merged. The first part keeps its index, the second is appended; pixels
    between them have a label above all indices.
    """
    typical = float(np.median(segments.area_px)) if len(segments.area_px) else 0.0
    size = segments.area_px / max(typical, 1.0)
    doubtful = wanted & (size > _LEAST_AREA) & (size < _LARGEST_AREA) & ~segments.at_border
    doubtful &= segments.roundness < _ROUNDEST
    pairs = [(int(blob), pair) for blob in np.flatnonzero(doubtful) if (pair := _part(segments, height, int(blob)))]
    if not pairs:
        return segments
    labels = segments.labels.copy()
    count = len(segments.area_px)
    nobody = count + len(pairs) + 1
    area, middle = list(segments.area_px), list(segments.middle_px)
    spread, contrast = list(segments.spread), list(segments.contrast)
    for number, (blob, (first, second)) in enumerate(pairs):
        other, half = count + number, segments.area_px[blob] / 2.0
        _relabel(labels, (blob + 1, other + 1, nobody), np.stack([first, second]), np.sqrt(half / np.pi))
        disc = np.array([1.0, 0.0, 1.0]) * half / (4.0 * np.pi)
        area[blob], middle[blob], spread[blob] = half, first, disc
        area.append(half)
        middle.append(second)
        spread.append(disc)
        contrast.append(contrast[blob])
    return replace(
        segments,
        labels=labels,
        area_px=np.array(area),
        middle_px=np.array(middle),
        spread=np.array(spread),
        contrast=np.array(contrast),
        at_border=np.append(segments.at_border, np.zeros(len(pairs), bool)),
    )


def _part(segments: Segments, height: Image, blob: int) -> tuple[FloatArray, FloatArray] | None:
    """Return the centres of the two parts of a blob; `None` without a waist."""
    xx, xy, yy = segments.spread[blob]
    large, small = (xx + yy) / 2.0 + np.hypot((xx - yy) / 2.0, xy), (xx + yy) / 2.0 - np.hypot((xx - yy) / 2.0, xy)
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    way = np.array([np.cos(angle), np.sin(angle)])
    half = float(np.sqrt(large - small))
    middle = segments.middle_px[blob]
    top, left, bottom, right = _window(segments.labels.shape, middle, half + 2.0 * float(np.sqrt(small)) + 1.0)
    rows, columns = np.nonzero(segments.labels[top:bottom, left:right] == blob + 1)
    along = (np.column_stack([columns + left, rows + top]) - middle) @ way
    level = height[rows + top, columns + left]

    def across(place: float) -> float:
        # a weight that falls off over one pixel adds up to the same wherever rows and columns lie
        return float((level * np.maximum(1.0 - np.abs(along - place), 0.0)).sum())

    if across(0.0) > _WAIST * min(across(-half), across(half)):
        return None
    return middle - half * way, middle + half * way


def _relabel(labels: NDArray[np.int32], names: tuple[int, int, int], centres: FloatArray, radius: float) -> None:
    """Label the pixels of a blob and its surroundings by the nearer of two centres, or as unassigned."""
    own, other, nobody = names
    apart = centres[1] - centres[0]
    length = float(np.linalg.norm(apart))
    top, left, bottom, right = _window(labels.shape, centres.mean(axis=0), length + radius + _MARGIN_PX)
    part = labels[top:bottom, left:right]
    rows, columns = np.nonzero((part == own) | (part == 0))
    places = np.column_stack([columns + left, rows + top])
    along = (places - centres.mean(axis=0)) @ (apart / length)
    near = np.linalg.norm(places[:, None] - centres, axis=-1).min(axis=1) < radius + _MARGIN_PX
    side = np.where(np.abs(along) < _BETWEEN_PX, nobody, np.where(along > 0.0, other, own))
    part[rows[near], columns[near]] = side[near]


def _window(shape: tuple[int, ...], middle: FloatArray, reach: float) -> tuple[int, int, int, int]:
    """Return rows and columns around a place: top, left, bottom, right."""
    column, row = middle
    top, left = max(int(row - reach), 0), max(int(column - reach), 0)
    return top, left, min(int(row + reach) + 2, shape[0]), min(int(column + reach) + 2, shape[1])
