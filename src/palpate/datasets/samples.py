"""Samples of a signal: values at the times of images, and clock offset of the images."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError, load_opencv
from palpate.datasets.recording_images import Item

_GAP = 3.0
"""Largest time between the samples around an image, over their median period. By hand."""
LEAST_SAMPLES = 8
"""Minimum number of images and samples from which a clock offset is estimated. By hand."""
_RANGE_S, _FINE = 1.0, 0.25
"""Largest clock offset that is searched, s, and its step over the time between images. By hand."""
_SURE, _BETTER = 0.6, 0.7
"""Minimum correlation of image change and motion; maximum ratio of residual variances. By hand."""
_SMALL = 24
"""Side of the images whose change is measured, px. By hand."""


class Samples(NamedTuple):
    """Values (n, k) of a signal at ascending times (n,) s."""

    time: FloatArray
    values: FloatArray

    @classmethod
    def of(cls, time: FloatArray, values: FloatArray) -> Samples:
        """Return samples in ascending time, each time once."""
        order = np.unique(time, return_index=True)[1]
        return cls(time[order], values[order])

    def surround(self, asked: FloatArray) -> NDArray[np.bool_]:
        """Return whether two samples surround each time closely enough (n,)."""
        known = self.time
        if len(known) < 2:
            return np.zeros(len(asked), bool)
        after = np.clip(np.searchsorted(known, asked), 1, len(known) - 1)
        gap = known[after] - known[after - 1]
        inside = (asked >= known[0]) & (asked <= known[-1])
        return np.asarray(inside & (gap <= _GAP * np.median(np.diff(known))))

    def at(self, asked: FloatArray) -> FloatArray:
        """Return the values (n, k) at times, linearly interpolated; NaN if samples do not surround a time."""
        found = np.column_stack([np.interp(asked, self.time, column) for column in self.values.T])
        return np.asarray(np.where(self.surround(asked)[:, None], found, np.nan))


def shrink(image: Item) -> FloatArray:
    """Return a small grey image, NaN for one that cannot be read."""
    if isinstance(image, PalpateError):
        return np.full((_SMALL, _SMALL), np.nan)
    cv2, grey = load_opencv(), image if image.ndim == 2 else image.mean(axis=2)
    return np.asarray(cv2.resize(grey.astype(np.float32), (_SMALL, _SMALL), interpolation=cv2.INTER_AREA), float)


def find_offset(
    time: FloatArray, small: FloatArray, known: FloatArray, ways: Sequence[FloatArray], noun: str
) -> tuple[float, tuple[str, ...]]:
    """Estimate the time by which images are later than a signal, s, from their change; 0 if unclear.

    Parameters
    ----------
    time, small
        Ascending times (n,) s of the images, and the images from `shrink`.
    known, ways
        Times (m,) s of the samples, and one or more distances (m - 1,) from sample to sample.
    noun
        Name of the samples in the note.

    Returns
    -------
    tuple
        Offset, s, and a note on it.
    """
    period = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    if len(time) < LEAST_SAMPLES or period <= 0 or len(known) < LEAST_SAMPLES:
        return 0.0, ()
    change = np.mean(np.diff(small, axis=0) ** 2, axis=(1, 2))
    paths = [np.cumsum(np.concatenate([[0.0], way])) for way in ways]

    def correlation(offset: float) -> float:
        """Return the correlation of image change with squared distances, by least squares."""
        at = time - offset
        both = np.isfinite(change) & (at[:-1] > known[0]) & (at[1:] < known[-1])
        if both.sum() < LEAST_SAMPLES:
            return -1.0
        squares = np.column_stack([np.diff(np.interp(at, known, path))[both] ** 2 for path in paths])
        inputs = np.column_stack([squares / np.maximum(squares.max(axis=0), 1e-300), np.ones(both.sum())])
        fitted = inputs @ np.linalg.lstsq(inputs, change[both], rcond=None)[0]
        if np.std(fitted) <= 1e-12 * np.abs(fitted).max() or np.std(change[both]) == 0:
            return -1.0
        return float(np.corrcoef(fitted, change[both])[0, 1])

    offsets = np.arange(-_RANGE_S, _RANGE_S, _FINE * min(period, 0.1))
    found = np.array([correlation(offset) for offset in offsets])
    best = int(np.argmax(found))
    if not 0 < best < len(found) - 1:
        return 0.0, ()
    is_better = 1.0 - found[best] ** 2 < _BETTER * (1.0 - correlation(0.0) ** 2)
    if found[best] < _SURE or not is_better or abs(offsets[best]) < 0.5 * period:
        return 0.0, ()
    low, mid, high = found[best - 1 : best + 2]
    offset = float(offsets[best] + 0.5 * (low - high) / min(low - 2 * mid + high, -1e-12) * (offsets[1] - offsets[0]))
    return offset, (
        f"images come {1e3 * offset:.0f} ms later than {noun}, by their motion (correlation {mid:.2f}); corrected",
    )
