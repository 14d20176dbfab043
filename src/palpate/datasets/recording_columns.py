"""Meaning of the columns of a table: image, press, or a quantity of the pose with its unit.

Columns are recognised by their names. If a name has two meanings, a flag is required. Angles are converted to
degrees, lengths to mm.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import PurePosixPath

import numpy as np
from numpy.typing import NDArray

from palpate.camera import IMAGE_SUFFIXES
from palpate.core import FloatArray, PalpateError
from palpate.core.units import is_unit, split_unit
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.table import RecordingTable, as_numbers

_IMAGE = (
    "image",
    "image_name",
    "image_file",
    "image_path",
    "filename",
    "file_name",
    "file",
    "img",
    "path",
    "sensor_image",
    "frame",
    "bild",
    "bilddatei",
    "fichier",
    "图像",
    "画像",
)
_PRESS = (
    *("press", "contact", "touch", "tap", "trial", "episode", "episode_index", "demo", "group", "run"),
    *("kontakt", "appui", "接触"),
)
INDEX = ("index", "id", "frame", "frame_index", "timestamp", "time", "t", "n", "row", "task_index", "unnamed: 0", "")
"""Names of columns that number the rows."""
_ANGLE = re.compile(
    r"(^|[_ ])(r[xyz]|rot\w*|euler\w*|roll|pitch|yaw|tilt|angle|theta|phi|psi|alpha|beta|gamma|winkel|a|b|c)"
    r"([_ \d]|$)|angle"
)
_LENGTH = re.compile(
    r"(^|[_ ])([xyz]|t[xyz]|d[xyz]|depth|shear\w*|offset|height|penetration|indentation)([_ \d]|$)|depth|shear"
    r"|tiefe|profondeur|深"
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
    **dict.fromkeys(("fz", "load", "kraft", "normal_force", "力"), "force"),
    **{"roll": "rx", "pitch": "ry", "yaw": "rz"},
    **{f"{word}_{axis}": f"r{axis}" for word in ("euler", "rot", "rotation", "angle") for axis in "xyz"},
    **dict.fromkeys(
        ("z", "penetration", "indentation", "tiefe", "eindringtiefe", "profondeur", "深度", "深さ"), "depth"
    ),
}
"""Alternative names of axes, used if no column has the name itself."""
_STILL, _FEW_MISSING = 1e-9, 0.1
"""Relative range of a constant column: rounding; share of rows without a number that loses a column.
By hand."""
_JUMP, _GAP = 150.0, 45.0
"""Degrees beyond which angles jump at ±180°, and the gap by which their circle can be opened. By hand."""
_TURN = 3.5
"""Angles that stay below it may be radians, lengths that stay below a tenth of it metres. By hand."""


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


def find_image_column(table: RecordingTable, choice: ColumnMapping) -> str:
    """Name of the column that names images, or numbers them.

    Raises
    ------
    PalpateError
        If the table has no such column, or several.
    """
    if choice.image:
        return _given(table, choice.image, "--image")
    named = [name for name in table.columns if name.strip().lower() in _IMAGE and _names_images(table, name)]
    held = named or [name for name in table.columns if _names_images(table, name)]
    if len(held) == 1:
        return held[0]
    if held:
        raise PalpateError(
            f"The columns {', '.join(held)} of {table.name} all name images.",
            "Choose one by --image.",
            code="column-ambiguous",
        )
    called = [name for name in table.columns if name.strip().lower() in _IMAGE]
    for kind in (True, False):  # numbers, or names without their ending
        if len(alike := [name for name in called if table.is_numeric(name) is kind]) == 1:
            return alike[0]
    raise PalpateError(
        f"No column of {table.name} names images; it has {list_columns(table)}.",
        "Name the column of image files by --image.",
        code="image-column-missing",
    )


def find_press_column(table: RecordingTable, choice: ColumnMapping) -> str:
    """Return the column of the press of an image; empty without one."""
    if choice.press:
        return _given(table, choice.press, "--press")
    return next((name for name in table.columns if name.strip().lower() in _PRESS), "")


def find_pose_columns(
    table: RecordingTable, choice: ColumnMapping, taken: tuple[str, ...]
) -> tuple[tuple[PoseColumn, ...], tuple[PoseColumn, ...], tuple[str, ...]]:
    """Find the quantities of the pose.

    Parameters
    ----------
    table, choice
        The table, and the meaning of its columns.
    taken
        Columns with another meaning.

    Returns
    -------
    tuple
        Quantities to estimate, further numbers of the motion, and a sentence for each column left out.

    Raises
    ------
    PalpateError
        If no quantity is left, or a column has wrong values; the message names the column.
    """
    table, asked = _rename(table, choice.targets)
    learn = tuple(_given(table, name, "--targets") for name in asked)
    poses, left_out, doubts = [], [], []
    for name in table.columns:
        wanted = name in learn
        if name in taken and not wanted:
            continue
        why = _why_not(table, name)
        if why and wanted:
            raise PalpateError(
                f"Column {name} cannot be estimated: {why}.",
                "Correct it, or leave it out of --targets.",
                code="column-not-trainable",
            )
        if why:
            left_out.append(f"Column {name} is left out: {why}.")
            continue
        try:
            poses.append(with_unit(table, name, choice))
        except PalpateError as error:
            if learn and not wanted:
                left_out.append(f"Column {name} is left out: {error.problem}")
            else:
                doubts.append(error)
    if doubts:
        raise PalpateError(" ".join(error.problem for error in doubts), doubts[0].remedy, code=doubts[0].code)
    poses, wraps = _unwrap(name_axes(poses), learn)
    left_out += wraps
    chosen = [one for one in poses if one.column in learn] if learn else _usual(poses)
    if not chosen:
        raise PalpateError(
            f"{table.name} has no column to learn: " + (" ".join(left_out) or f"it has {list_columns(table)}."),
            "Give columns of numbers that vary by --targets.",
            code="columns-none",
        )
    if learn:
        chosen.sort(key=lambda one: learn.index(one.column))
    others = tuple(one for one in poses if one not in chosen)
    return tuple(chosen), others, tuple(left_out)


def find_gaps(table: RecordingTable, choice: ColumnMapping) -> tuple[RecordingTable, NDArray[np.bool_], str]:
    """Rows in which a few numbers of the pose are missing.

    Returns
    -------
    tuple
        The table without the faults of these rows, (n,) whether a row is one of them, and a sentence; empty without
        such rows.
    """
    gaps, names = np.zeros(len(table), bool), []
    asked = {text.partition("=")[0].strip().casefold() for text in choice.targets}
    for name, values in table.columns.items():
        short = short_name(split_unit(name.strip().lower())[0])
        wanted = name.casefold() in asked if asked else AXES.get(short, short) in ("rx", "ry", "depth")
        typed = name in table.faults and "'nan'" not in table.faults[name].lower()
        if wanted and table.is_numeric(name) and not typed:
            missing = ~np.isfinite(as_numbers(values))
            if 0 < missing.sum() <= _FEW_MISSING * len(values):
                gaps |= missing
                names.append(name)
    if not 0 < gaps.sum() <= _FEW_MISSING * len(gaps):
        return table, np.zeros(len(table), bool), ""
    faults = {name: fault for name, fault in table.faults.items() if name not in names}
    said = f"{gaps.sum()} of {len(gaps)} rows are left out: without a number in {', '.join(names)}"
    return replace(table, faults=faults), gaps, said


def _rename(table: RecordingTable, learn: tuple[str, ...]) -> tuple[RecordingTable, tuple[str, ...]]:
    """The table with columns by the names that the user gives them, ``pose_4=rx_deg``; these names."""
    pairs = [text.partition("=") for text in learn]
    new = {_given(table, old.strip(), "--targets"): name.strip() for old, mark, name in pairs if mark}
    twice = [name for name in new.values() if not name or name in table.columns]
    if twice:
        raise PalpateError(
            f"A column cannot be called '{twice[0]}'.",
            "Give another name after the = of --targets.",
            code="column-name-reserved",
        )
    columns = {new.get(name, name): values for name, values in table.columns.items()}
    faults = {new.get(name, name): fault for name, fault in table.faults.items()}
    return RecordingTable(table.name, columns, faults), tuple(
        (name if mark else old).strip() for old, mark, name in pairs
    )


def _unwrap(poses: list[PoseColumn], learn: tuple[str, ...]) -> tuple[list[PoseColumn], list[str]]:
    """Angles without jumps at ±180°, and sentences on those that go round and are left out."""
    kept, notes = [], []
    for one in poses:
        values = one.values
        if one.unit != "deg" or not (values.max() > _JUMP and values.min() < -_JUMP):
            kept.append(one)
            continue
        order = np.sort(values % 360)
        gaps = np.diff(np.append(order, order[0] + 360))
        if gaps.max() >= _GAP:
            start = order[(int(np.argmax(gaps)) + 1) % len(order)]
            whole = (values - start) % 360 + start
            note = f"Column {one.column} jumps at ±180° and is continued to {whole.min():.0f}..{whole.max():.0f}°."
            kept.append(PoseColumn(one.column, one.axis, one.unit, whole, note))
        elif one.column in learn or (not learn and one.axis in ("rx", "ry")):
            raise PalpateError(
                f"Column {one.column} jumps between -180 and 180°, which no estimator can learn.",
                "Give poses relative to the surface, or --orientation and --frame.",
                code="angle-jumps",
            )
        else:
            notes.append(f"Column {one.column} is left out: it jumps between -180 and 180°.")
    return kept, notes


def _usual(poses: list[PoseColumn]) -> list[PoseColumn]:
    axes = [one.axis for one in poses]
    if all(axis in axes for axis in ("rx", "ry", "depth")):
        return [poses[axes.index(axis)] for axis in ("rx", "ry", "depth")]
    return poses


def name_axes(poses: list[PoseColumn]) -> list[PoseColumn]:
    """Return the columns with the axis names of palpate, unless two would be equal."""
    axes = [one.axis for one in poses]
    renamed = []
    for one in poses:
        other = AXES.get(one.axis, one.axis)
        axis = other if other not in axes else one.axis
        renamed.append(PoseColumn(one.column, axis, one.unit, one.values, one.note))
    return renamed


def _why_not(table: RecordingTable, name: str) -> str:
    if not table.is_numeric(name):
        return "it holds text, no numbers"
    values = as_numbers(table.columns[name])
    known = values[np.isfinite(values)]
    if name in table.faults:
        return table.faults[name]
    if len(known) < len(values):
        return f"{len(values) - len(known)} of its {len(values)} cells are empty or not finite"
    if float(np.ptp(known)) <= _STILL * max(1.0, float(np.abs(known).max())):
        return f"it is {known[0]:g} throughout"
    if name.strip().lower() in INDEX:
        return "it numbers the rows"
    step = np.diff(known)
    if len(known) > 10 and np.all(step == 1.0):
        return "it counts the rows"
    return ""


def with_unit(table: RecordingTable, name: str, choice: ColumnMapping) -> PoseColumn:
    """A column in the units of the program.

    Raises
    ------
    PalpateError
        If its name has no unit and its values leave two open.
    """
    values = as_numbers(table.columns[name])
    low = name.strip().lower()
    bare, unit = split_unit(low)
    most, note = float(np.nanmax(np.abs(values), initial=0.0)), ""
    if unit not in FACTORS or not bare:
        bare = low
        if (
            is_unit(unit)
            and unit not in ("-", "1")
            and re.search(r"[(\[]", low)
            and not choice.angles + choice.lengths
        ):
            return PoseColumn(name, short_name(low), "1", values, f"Column {name} is in {unit}; it is kept.")
        if _ANGLE.search(low):
            unit = choice.angles or ("deg" if most > _TURN and not _fits_circle(values) else "")
            other, flag = (
                "radians or degrees",
                "--angles deg or --angles rad; near π, the tool points down in radians",
            )
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


def _fits_circle(values: FloatArray) -> bool:
    """Return whether angles lie in 0 to 2π about π or, on both sides, about 0: radians of one orientation."""
    known = values[np.isfinite(values)]
    away = np.abs(known - np.pi)
    return bool(known.min() >= 0 and away.max() <= np.pi and (away.max() < np.pi / 3 or away.min() > 2 * np.pi / 3))


def short_name(name: str) -> str:
    """Return the name of an axis without prefixes: ``pose_Rx`` is ``rx``."""
    short = re.sub(r"^(pose|robot|tcp|sensor|target|gt|label)[_ ]+", "", name.strip(" _[]()"))
    return re.sub(r"\W+", "_", short) or "value"


def _names_images(table: RecordingTable, name: str) -> bool:
    if table.is_numeric(name):
        return False
    first = [text for text in table.columns[name][:50].tolist() if text]
    return bool(first) and all(PurePosixPath(text).suffix.lower() in IMAGE_SUFFIXES for text in first)


def _given(table: RecordingTable, name: str, flag: str) -> str:
    alike = [column for column in table.columns if column.strip().lower() == name.strip().lower()]
    if not alike:
        raise PalpateError(
            f"{table.name} has no column {name}; it has {list_columns(table)}.",
            f"Choose one of these by {flag}.",
            code="column-unknown",
        )
    return alike[0]


def list_columns(table: RecordingTable) -> str:
    """Names of the first columns, for messages."""
    names = list(table.columns)
    return ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
