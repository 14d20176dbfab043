"""Relaxation test from the file of a test machine: time, stress, and strain if measured."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.core.tables import Table
from palpate.material.columns import (
    FORCE_NAMES,
    STRAIN,
    STRESS,
    STRETCH,
    empty_cell,
    find_column,
    read_columns,
    refuse_faults,
    seek_column,
)
from palpate.material.relaxation_test import RelaxationTest
from palpate.material.spec import StrainUnit, TestFileSpec, TimeUnit

_TIME = re.compile(r"time|zeit|temps|tempo|tiempo|时间|時間|\bt\b|\bt[ _(\[]", re.I)
_MODULUS = re.compile(r"modul|relax|模量|弾性率", re.I)
_EXTENDED = re.compile(
    r"extension|displacement|travel|d[ée]placement|spostamento|desplazamiento|deslocamento|位移|変位", re.I
)
"""Names of travel from rest; a position may begin anywhere."""
_SECONDS = {TimeUnit.MILLISECOND: 1e-3, TimeUnit.SECOND: 1.0, TimeUnit.MINUTE: 60.0, TimeUnit.HOUR: 3600.0}
"""Seconds a unit."""
_UNITS = {"ms": "ms", **dict.fromkeys(("s", "sec", "sek", "seconds", "秒"), "s"), "min": "min", "h": "h", "hour": "h"}


def read_relaxation(path: str | Path, spec: TestFileSpec | None = None) -> RelaxationTest:
    """Read a relaxation test.

    Parameters
    ----------
    path
        CSV or other text with columns of time and of stress, force or modulus. With a column of strain or travel, the
        stress is the response to that strain, otherwise to a step.
    spec
        Format that the file does not state. Units of stress and strain do not matter, nor do section and gauge
        length.

    Raises
    ------
    PalpateError
        If the file is wrong or ambiguous, or has no relaxation; the message names row, column and remedy.
    """
    path, spec = Path(path), spec or TestFileSpec()
    table = read_columns(path, spec)
    time_at = find_column(table, spec.time, "time", (_TIME,))
    stress_at = find_column(table, spec.stress, "stress", (STRESS, _MODULUS, *FORCE_NAMES))
    strain_at = seek_column(table, spec.strain, "strain", (STRAIN, _EXTENDED))
    columns = [time_at, stress_at, *([] if strain_at is None else [strain_at])]
    twice = [column for column in columns if columns.count(column) > 1]
    if twice:
        raise PalpateError(
            f"{path}: column {twice[0] + 1} is taken twice.",
            "Give --time, --stress and --strain by number.",
            code="column-taken-twice",
        )
    values = _take(table, columns)
    time = values[:, 0] * _SECONDS[_time_unit(table, time_at, spec)]
    stress, notes = _signed(values[:, 1]), []
    strain = None
    if strain_at is not None:
        strain = _strain(table, values[:, 2], strain_at, spec)
        notes.append("answer to the strain measured")
    test = RelaxationTest(path.name, time, stress, strain, tuple(notes))
    test.check()
    if strain is None and test.ramp_times[1] > test.ramp_times[0]:
        notes.append("no strain: assumed to increase linearly up to the maximum stress")
    elif strain is None:
        notes.append("no strain: taken to have come as a step at time 0")
    return replace(test, notes=tuple(notes))


def _take(table: Table, columns: list[int]) -> FloatArray:
    """Columns (n, k) without the rows in which all of them are empty."""
    for column in columns:
        refuse_faults(table, column)
    values = np.stack([table.numbers(column) for column in columns], axis=1)
    filled = ~np.isnan(values).all(axis=1)
    values, lines = values[filled], table.lines[filled]
    if not len(values):
        raise PalpateError(
            f"{table.path}: the columns of time and stress are empty.", "Give other columns.", code="columns-empty"
        )
    for row, at in np.argwhere(np.isnan(values)):
        raise empty_cell(table, lines[row], columns[at])
    return values


def _time_unit(table: Table, column: int, spec: TestFileSpec) -> TimeUnit:
    if spec.time_unit is not None:
        return spec.time_unit
    if (written := table.unit(column).lower()) in _UNITS:
        return TimeUnit(_UNITS[written])
    raise PalpateError(
        f"{table.path}: the time (column {column + 1}) is without a unit.",
        f"Give --time-unit: {', '.join(TimeUnit)}.",
        code="column-unit-unknown",
    )


def _signed(stress: FloatArray) -> FloatArray:
    """Stress with the sign for which its extreme value is positive."""
    return np.asarray(stress * np.sign(stress[np.argmax(np.abs(stress))] or 1.0))


def _strain(table: Table, strain: FloatArray, column: int, spec: TestFileSpec) -> FloatArray:
    """Strain that increases from zero, in the file's unit."""
    name = table.header[column]
    if spec.strain_unit is StrainUnit.STRETCH or (spec.strain_unit is None and STRETCH.search(name)):
        strain = strain - 1.0
    strain = _signed(strain)
    if not np.abs(strain).max() > 0:
        raise PalpateError(
            f"{table.path}: the strain (column {column + 1}) stays at 0.",
            "Check the column of strain.",
            code="strain-zero",
        )
    return strain
