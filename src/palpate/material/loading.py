"""Loading branch of a curve, whatever the order of its rows.

Rows of a single curve are sorted by stretch. If a specimen was unloaded, or broke and sprang back, a stretch has two
stresses, and the order of the rows separates them. This case is recognised by rows that run through the range in few
sweeps, each smoother than all rows sorted together.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, IntArray
from palpate.material.sample import Loading, Sample

_BROKEN = 0.8
"""A later stress below this share of the maximum is that of a broken specimen. By hand."""
_TURN = 0.02
"""Share of the range by which the stretch must reverse to end a sweep; less is noise of the machine.
By hand."""
_IN_SWEEPS = 0.6
"""Minimum share of the rows within sweeps, not at their ends: of shuffled rows it is a third."""
_ROUGHER = 2.0
"""Ratio of the roughness of sorted rows to that of the sweeps from which there are several branches.
By hand."""
MIN_ROWS = 4
"""Minimum number of rows of a loading: machines write tens or more. By hand."""
_SMOOTH = 2e-3
"""Roughness over the maximum stress below which there is a single branch. By hand."""


def loading_branch(sample: Sample) -> Sample:
    """Return the rows of loading, sorted outward from rest, without those after break or unloading.

    Parameters
    ----------
    sample
        As read, in any order; with several branches, in the order of time.

    Returns
    -------
    Sample
        Its rows up to the maximum stretch; all rows, sorted, if a file contains tension and compression.
    """
    if sample.loading is Loading.UNIAXIAL:
        return sample.where(np.argsort(sample.stretch, kind="stable"))
    far = int(np.argmax(np.abs(sample.stretch - 1)))
    outward = -1 if sample.stretch[far] < 1 else 1
    sweeps = find_sweeps(sample.stretch)
    if len(sweeps) == 1 and far < len(sample.stretch) - 1 - far:
        sample = sample.where(np.arange(len(sample.stretch))[::-1])
        far = len(sample.stretch) - 1 - far
    sorted_rows = np.argsort(outward * sample.stretch, kind="stable")
    if len(sweeps) == 1 or (far >= MIN_ROWS and _is_two_valued(sample, sweeps, sorted_rows)):
        before = _before_break(sample.where(np.arange(far + 1)), outward)
        return before.where(np.argsort(outward * before.stretch, kind="stable"))
    return _before_break(sample.where(sorted_rows), outward)


def _before_break(sample: Sample, outward: int) -> Sample:
    """The rows up to the maximum stress, if a much smaller one follows."""
    size = outward * sample.nominal
    peak = int(np.argmax(size))
    broken = np.any(size[peak:] < _BROKEN * size[peak])
    return sample.where(np.arange(peak + 1)) if broken else sample


def find_sweeps(stretch: FloatArray) -> list[IntArray]:
    """Rows of each sweep from one turning point to the next, in the order of the file."""
    least = _TURN * float(np.ptp(stretch))
    turns, low, high, rising = [0], 0, 0, 0
    for at in range(1, len(stretch)):
        high = at if stretch[at] > stretch[high] else high
        low = at if stretch[at] < stretch[low] else low
        if rising >= 0 and stretch[at] < stretch[high] - least:
            turns += [high] if rising else []
            rising, low = -1, at
        elif rising <= 0 and stretch[at] > stretch[low] + least:
            turns += [low] if rising else []
            rising, high = 1, at
    ends = [*turns[1:], len(stretch) - 1]
    return [np.arange(start, end + 1) for start, end in zip(turns, ends, strict=True)]


def _is_two_valued(sample: Sample, sweeps: list[IntArray], sorted_rows: IntArray) -> bool:
    """Whether the sweeps are separate branches, not pieces of one curve in disorder.

    Two sweeps, out and back, always are.
    """
    if len(sweeps) == 2 and min(map(len, sweeps)) > MIN_ROWS:
        return True
    along, across = np.full((2, len(sample.stretch)), np.nan)
    for sweep in sweeps:
        _write_misses(sample, sweep[np.argsort(sample.stretch[sweep], kind="stable")], along)
    _write_misses(sample, sorted_rows, across)
    both = np.isfinite(along) & np.isfinite(across)
    if both.sum() < max(_IN_SWEEPS * (len(sample.stretch) - 2), 3):
        return False
    floor = _SMOOTH * float(np.abs(sample.nominal).max())
    return bool(_rms(across[both]) > max(_ROUGHER * _rms(along[both]), floor))


def _write_misses(sample: Sample, rows: IntArray, misses: FloatArray) -> None:
    """Distance of each inner row from the line through its neighbours, MPa, scaled to the noise."""
    stretch, nominal = sample.stretch[rows], sample.nominal[rows]
    span = stretch[2:] - stretch[:-2]
    share = np.where(span == 0, 0.5, (stretch[1:-1] - stretch[:-2]) / np.where(span == 0, 1.0, span))
    line = nominal[:-2] + share * (nominal[2:] - nominal[:-2])
    misses[rows[1:-1]] = (nominal[1:-1] - line) / np.sqrt(1 + share**2 + (1 - share) ** 2)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
