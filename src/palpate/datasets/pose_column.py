"""One quantity of the pose in a table: its axis, and its values in deg, mm, N or Nm."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.core.units import is_unit, split_lower
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.table import RecordingTable, as_numbers

_ANGLE = re.compile(
    r"(^|[_ ])(r[xyz]|rot\w*|euler\w*|roll|pitch|yaw|tilt|angle|theta|phi|psi|alpha|beta|gamma|winkel|a|b|c)"
    r"([_ \d]|$)|angle"
)
_LENGTH = re.compile(
    r"(^|[_ ])([xyz]|t[xyz]|d[xyz]|depth|shear\w*|offset|height|penetration|indentation)([_ \d]|$)|depth|shear"
    r"|tiefe|profondeur|深|(position|translation)[./]+[xyz]$"
)
FACTORS = {
    **dict.fromkeys(("deg", "degree", "degrees", "°", "度"), ("deg", 1.0)),
    **dict.fromkeys(("rad", "radian", "radians", "弧度"), ("deg", 180.0 / np.pi)),
    "mrad": ("deg", 0.18 / np.pi),
    **dict.fromkeys(("mm", "毫米"), ("mm", 1.0)),
    **dict.fromkeys(("um", "µm", "μm"), ("mm", 1e-3)),
    **{"cm": ("mm", 10.0), "m": ("mm", 1e3)},
    **dict.fromkeys(("in", "inch", "inches"), ("mm", 25.4)),
    **{"n": ("N", 1.0), "mn": ("N", 1e-3), "kn": ("N", 1e3), "gf": ("N", 9.80665e-3), "kgf": ("N", 9.80665)},
    "lbf": ("N", 4.4482216152605),
    **dict.fromkeys(("nm", "n·m", "n*m", "n.m", "n-m"), ("Nm", 1.0)),
    **{**dict.fromkeys(("nmm", "n·mm", "n-mm", "mnm"), ("Nm", 1e-3)), "kgfm": ("Nm", 9.80665)},
}
"""Unit that is written → unit of the program and factor."""
AXES = {
    **dict.fromkeys(("fz", "fn", "f_z", "force_z", "load", "kraft", "normalkraft", "normal_force", "力"), "force"),
    **{"roll": "rx", "pitch": "ry", "yaw": "rz"},
    **{f"{word}_{axis}": f"r{axis}" for word in ("euler", "rot", "rotation", "angle") for axis in "xyz"},
    **dict.fromkeys(
        ("z", "penetration", "indentation", "tiefe", "eindringtiefe", "profondeur", "深度", "深さ"), "depth"
    ),
}
"""Alternative names of axes, used if no column has the name itself."""
_TURN = 3.5
"""Angles that stay below it may be radians, lengths that stay below a tenth of it metres. By hand."""
_CIRCLE = 7.0
"""Radians beyond which roll, pitch and yaw without units are in degrees: just over one turn."""


@dataclass(frozen=True, eq=False)
class PoseColumn:
    """One quantity of the pose.

    Attributes
    ----------
    column
        Name in the table.
    axis, unit
        Short name, and unit of `values`: deg, mm, N, or 1 if not stated.
    values
        (n,) numbers in this unit.
    note
        Conversions and assumptions; may be empty.
    """

    column: str
    axis: str
    unit: str
    values: FloatArray
    note: str = ""


def name_axes(poses: list[PoseColumn]) -> list[PoseColumn]:
    """Return the columns with the axis names of palpate, unless two would be equal."""
    axes = [one.axis for one in poses]
    renamed = []
    for one in poses:
        other = AXES.get(one.axis, one.axis)
        axis = other if other not in axes else one.axis
        renamed.append(PoseColumn(one.column, axis, one.unit, one.values, one.note))
    return renamed


def with_unit(table: RecordingTable, name: str, choice: ColumnMapping) -> PoseColumn:
    """A column in the units of the program.

    Raises
    ------
    PalpateError
        If its name has no unit and its values leave two open.
    """
    values = as_numbers(table.columns[name])
    low = name.strip().lower()
    bare, unit = split_lower(name)
    most, note = float(np.nanmax(np.abs(values), initial=0.0)), ""
    if unit not in FACTORS or not bare:
        bare = low
        written = is_unit(unit) and unit not in ("-", "1") and bool(re.search(r"[(\[]", low))
        if written and not choice.angles + choice.lengths:
            return PoseColumn(name, short_name(low), "1", values, f"Column {name} is in {unit}; it is kept.")
        if _ANGLE.search(low):
            clear = most > _TURN and not _fits_circle(values)
            unit = choice.angles or ("deg" if clear or _are_degrees(table, low) else "")
            other = "radians or degrees"
            flag = "--angles deg or --angles rad; near π, the tool points down in radians"
        elif _LENGTH.search(low):
            unit = choice.lengths or ("mm" if most > _TURN / 10 else "")
            other, flag = "metres or mm", "--lengths mm or --lengths m"
        else:
            return PoseColumn(
                name, short_name(low), "1", values, f"Column {name} has no unit that is known; it is kept."
            )
        if not unit:
            raise PalpateError(
                f"Column {name} names no unit, and its values up to {most:.3g} may be {other}.",
                f"Give {flag}.",
                code="column-unit-unknown",
            )
        given = choice.angles if _ANGLE.search(low) else choice.lengths
        note = (
            "" if given else f"Column {name} names no unit; by its values, up to {most:.3g}, it is taken as {unit}."
        )
    target, factor = FACTORS[unit]
    return PoseColumn(name, short_name(bare), target, values * factor, note)


def _are_degrees(table: RecordingTable, low: str) -> bool:
    """Whether a column is one of roll, pitch and yaw without units, of which one exceeds a turn."""
    group = {name: AXES.get(short_name(name.strip().lower()), "") for name in table.columns if table.is_numeric(name)}
    group = {name: axis for name, axis in group.items() if axis in ("rx", "ry", "rz")}
    most = [np.nanmax(np.abs(as_numbers(table.columns[name])), initial=0.0) for name in group]
    return AXES.get(short_name(low), "") in group.values() and len(group) == 3 and max(most) > _CIRCLE


def _fits_circle(values: FloatArray) -> bool:
    """Return whether angles lie in 0 to 2π about π or, on both sides, about 0: radians of one orientation."""
    known = values[np.isfinite(values)]
    away = np.abs(known - np.pi)
    return bool(known.min() >= 0 and away.max() <= np.pi and (away.max() < np.pi / 3 or away.min() > 2 * np.pi / 3))


def short_name(name: str) -> str:
    """Return the name of an axis without prefixes: ``pose_Rx`` is ``rx``."""
    prefix = r"^(pose|robot|tcp|sensor|target|gt|label)[_ ]+|^.*(position|translation)[./]+(?=[xyz]$)"
    short = re.sub(prefix, "", name.strip(" _[]()"))
    return re.sub(r"\W+", "_", short) or "value"
