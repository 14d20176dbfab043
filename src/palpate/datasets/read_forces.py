"""Forces of a table with its own clock and rate, at the times of images."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError
from palpate.core.units import split_lower
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.pose_column import FACTORS
from palpate.datasets.recording_columns import TIME, list_columns
from palpate.datasets.recording_images import ImageSet
from palpate.datasets.samples import Samples, find_offset, shrink
from palpate.datasets.table import Column, RecordingTable, as_numbers, read_table

_SECONDS = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9}
"""Seconds a unit."""
_EPOCH_S = (1e9, 5e9)
"""Unix times, s, from 2001 to 2128; ms, us and ns of them lie in other ranges."""
_STEP_S = 0.5
"""Time steps without a unit below this are seconds: in ms they would mean 2000 samples a second."""
_AXIS = re.compile(r"(?:^|[_. /])(f|force|kraft|t|torque|m|moment)[_. ]*\[?([xyz])\]?$")
_ONE = ("force", "load", "kraft", "normal_force", "力")
"""Names of the force of a load cell."""


def add_forces(
    table: RecordingTable, images: ImageSet, choice: ColumnMapping
) -> tuple[RecordingTable, NDArray[np.bool_]]:
    """Add the forces (N, N m) of the file `choice.forces` at the times of images to their table.

    A clock offset is estimated by the change of images and forces.

    Returns
    -------
    tuple
        The table, and whether an image has a force (n,).

    Raises
    ------
    PalpateError
        If a column of time or force is missing or has an unknown unit, or the two times do not overlap.
    """
    assert choice.forces is not None
    found = read_table(choice.forces)
    names, values = _wrench(found, choice)
    (_, known), (clock, asked) = find_times(found, choice), find_times(table, choice)
    sound = np.isfinite(values).all(axis=1) & np.isfinite(known)
    samples = Samples.of(known[sound], values[sound])
    order = np.argsort(asked, kind="stable")
    if len(np.unique(asked)) < len(asked) and (np.diff(asked) < 0).any():
        raise PalpateError(
            f"The times of {table.name} begin again at row {int(np.argmax(np.diff(asked) < 0)) + 2}.",
            "Write times of one clock for all images.",
            code="times-restart",
        )
    small = np.array([shrink(item) for item in images.read(range(len(table)))])[order]
    way = np.linalg.norm(np.diff(samples.values, axis=0), axis=1)
    offset, notes = find_offset(asked[order], small, samples.time, (way,), f"forces of {found.name}")
    forces = samples.at(asked - offset)
    within = np.asarray(np.isfinite(forces).all(axis=1))
    if not within.any():
        (first, last), (begin, end) = _range(samples.time), _range(asked)
        raise PalpateError(
            f"{found.name} has forces at {first} to {last} s, {table.name} images at {begin} to {end} s.",
            "Record both at the same time, with one clock; --times states a unit of time.",
            code="forces-no-overlap",
        )
    if not within.all():
        notes += (f"{int((~within).sum())} of {len(within)} images have no force at their time and are left out",)
    columns = {name: cells for name, cells in table.columns.items() if name != clock}
    columns |= dict(zip(names, forces.T, strict=True))
    return replace(table, columns=columns, notes=(*table.notes, *notes)), within


def _range(time: FloatArray) -> tuple[str, str]:
    return f"{time.min(initial=np.inf):.3f}", f"{time.max(initial=-np.inf):.3f}"


def find_times(table: RecordingTable, choice: ColumnMapping) -> tuple[str, FloatArray]:
    """Column of times, and times (n,) s of the rows, by the unit in its name, the flag or the values."""
    for name in table.columns:
        match = TIME.fullmatch(name.strip().lower())
        values = _clock(table.columns[name]) if match else None
        if match is None or values is None:
            continue
        unit = "s" if table.columns[name].dtype.kind == "U" else match[1] or choice.times
        middle, step = np.nanmedian(values), np.nanmedian(np.abs(np.diff(values)))
        epochs = [one for one in ("s", *_SECONDS) if _EPOCH_S[0] <= middle * _SECONDS.get(one, 1.0) < _EPOCH_S[1]]
        unit = unit or (epochs[0] if epochs else "s" if step < _STEP_S else "")
        if not unit:
            raise PalpateError(
                f"Column {name} of {table.name} names no unit, and its steps of {step:.3g} may be seconds or less.",
                "Give --times s, ms, us or ns.",
                code="time-unit-unknown",
            )
        return name, values * _SECONDS.get(unit, 1.0)
    raise PalpateError(
        f"{table.name} has no column of times; it has {list_columns(table)}.",
        "Name it time_s, or timestamp with its unit.",
        code="time-column-missing",
    )


def _clock(values: Column) -> FloatArray | None:
    """Numbers, or dates (ISO 8601, in UTC without a zone) in s since 1970; `None` for other texts."""
    try:
        texts = values.tolist() if values.dtype.kind == "U" else []
        dates = [datetime.fromisoformat("1970-01-01 " * (text[2:3] == ":") + text) for text in texts]
    except ValueError:
        return None
    return np.array([(one if one.tzinfo else one.replace(tzinfo=UTC)).timestamp() for one in dates] or values)


def _wrench(table: RecordingTable, choice: ColumnMapping) -> tuple[list[str], FloatArray]:
    """Names of the forces and torques of a table, and their values (n, k), N and N m."""
    found: dict[str, FloatArray] = {}
    for name in table.columns:
        bare, unit = split_lower(name)
        axis = _AXIS.search(bare)
        if not table.is_numeric(name) or (axis is None and bare not in _ONE):
            continue
        torque = axis is not None and axis[1] in ("t", "torque", "m", "moment")
        target, factor = FACTORS.get(unit or choice.force_unit.lower() + ("m" if torque else ""), ("", 1.0))
        if target != ("Nm" if torque else "N"):
            raise PalpateError(
                f"Column {name} of {table.name} has the unit '{unit}'."
                if unit
                else f"Column {name} of {table.name} names no unit.",
                "Write a unit in its name, such as Fz_N and Tz_Nm, or give --force-unit N.",
                code="force-unit-unknown",
            )
        key = "force_N" if axis is None else f"{'t' if torque else 'f'}{axis[2]}_{target}"
        found.setdefault(key, factor * as_numbers(table.columns[name]))
    if not any(name.endswith("_N") for name in found):
        raise PalpateError(
            f"{table.name} has no column of a force; it has {list_columns(table)}.",
            "Name columns Fx_N, Fy_N, Fz_N.",
            code="force-columns-missing",
        )
    return list(found), np.column_stack(list(found.values()))
