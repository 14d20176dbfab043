"""Cyclic tests: selection of one state from loading and unloading at several levels.

An elastomer softens in its first cycles (Mullins 1969) and keeps a set, so a curve through all cycles mixes states.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.material.loading import MIN_ROWS, find_sweeps
from palpate.material.sample import Loading, Sample

_SAME_LEVEL = 0.03
"""Peaks nearer than this share of the range are one level; crossheads repeat a peak to about 1 %."""


def select_cycle(sample: Sample, cycle: int | None) -> tuple[Sample, ...]:
    """Select one state of a cyclic test; return other samples unchanged.

    Parameters
    ----------
    sample
        Rows in the order of time.
    cycle
        Cycle of each level, from 1, with the set removed: stretch and stress then refer to the specimen at the start
        of this cycle. `None` for first loading, the envelope of the virgin curve.

    Raises
    ------
    PalpateError
        If the test does not have this cycle.
    """
    outward = -1.0 if abs(sample.stretch.min() - 1) > abs(sample.stretch.max() - 1) else 1.0
    away = outward * (sample.stretch - 1)
    loadings = _loadings(away) if sample.loading is not Loading.UNIAXIAL else []
    if len(loadings) < 2:
        if cycle is not None and cycle > 1:
            raise PalpateError(
                f"{sample.name}: cycle {cycle} is asked for, and the file holds one loading.",
                "Leave out --cycle.",
                code="cycle-missing",
            )
        return (sample,)
    levels = _levels(loadings, away)
    said = f"cyclic test with {len(loadings)} cycles at {len(levels)} level{'s' if len(levels) > 1 else ''}"
    if cycle is None:
        rows = _envelope(loadings, away)
        return (replace(sample.where(rows), notes=(*sample.notes, f"{said}: first loading (envelope) is fitted")),)
    shortest = min(len(level) for level in levels)
    if cycle > shortest:
        raise PalpateError(
            f"{sample.name} is a {said}, of which one has {shortest}; cycle {cycle} is asked for.",
            f"Give --cycle from 1 to {shortest}.",
            code="cycle-missing",
        )
    found = []
    for level in levels:
        rows = level[cycle - 1]
        rest = _rest_stretch(sample, rows)
        name = f"{sample.name} to {sample.stretch[rows[-1]]:.3g}"
        note = f"{said}: cycle {cycle} of this level is fitted, set {100 * (rest - 1):.2g} % removed"
        kept = replace(
            sample,
            stretch=sample.stretch / rest,
            nominal=sample.nominal * rest,
            name=name,
            notes=(*sample.notes, note),
        ).where(rows)
        found.append(kept.where(outward * (kept.stretch - 1) >= -1e-9))
    return tuple(found)


def _loadings(away: FloatArray) -> list[IntArray]:
    """Rows of each loading of a cyclic test: sweeps out and back in turn, each of several rows."""
    sweeps = find_sweeps(away)
    if len(sweeps) < 3 or min(map(len, sweeps[:-1])) < MIN_ROWS:
        return []
    return [sweep for sweep in sweeps if away[sweep[-1]] > away[sweep[0]] and len(sweep) >= MIN_ROWS]


def _levels(loadings: list[IntArray], away: FloatArray) -> list[list[IntArray]]:
    """Loadings by the level that they reach, in the order of time."""
    span = float(np.ptp(away))
    levels: list[list[IntArray]] = []
    for rows in loadings:
        if levels and abs(away[rows[-1]] - away[levels[-1][-1][-1]]) <= _SAME_LEVEL * span:
            levels[-1].append(rows)
        else:
            levels.append([rows])
    return levels


def _envelope(loadings: list[IntArray], away: FloatArray) -> IntArray:
    """Rows that reach further than all rows before them: the virgin material."""
    rows = np.concatenate(loadings)
    before = np.maximum.accumulate(np.concatenate([[-np.inf], away[rows][:-1]]))
    return np.asarray(rows[away[rows] > before])


def _rest_stretch(sample: Sample, rows: IntArray) -> float:
    """Stretch at which a loading leaves zero stress: that of the specimen with its set."""
    stretch, size = sample.stretch[rows], np.abs(sample.nominal[rows])
    floor = 1e-3 * float(size.max())
    first = int(np.argmax(size > floor))
    if first == 0:
        slope = (size[1] - size[0]) / ((stretch[1] - stretch[0]) or np.inf)
        return float(stretch[0] - (size[0] / slope if abs(slope) > 0 else 0.0))
    return float(stretch[first - 1])
