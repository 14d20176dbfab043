"""Meaning of the columns of a table: image, press, or a quantity of the pose with its unit.

Columns are recognised by their names. If a name has two meanings, a flag is required. Angles are converted to
degrees, lengths to mm.
"""

from __future__ import annotations

import re
from pathlib import PurePosixPath

import numpy as np
from numpy.typing import NDArray

from palpate.camera import IMAGE_SUFFIXES
from palpate.core import PalpateError
from palpate.core.units import split_unit
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.pose_column import AXES, PoseColumn, name_axes, short_name, with_unit
from palpate.datasets.table import RecordingTable, as_numbers

_IMAGE = (
    *(
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
    ),
    *("frame", "bild", "bilddatei", "fichier", "图像", "画像"),
)
_PRESS = (
    *("press", "contact", "touch", "tap", "trial", "episode", "episode_index", "demo", "group", "run"),
    *("kontakt", "appui", "接触"),
)
INDEX = ("index", "id", "frame", "frame_index", "n", "row", "task_index", "unnamed: 0", "")
"""Names of columns that number the rows."""
TIME = re.compile(
    r"%?(?:.*[. /])?(?:time|time_?stamp|stamp|t|zeit|temps|时间|時刻)"
    r"(?:[\s_/,(\[]+(?:in\s+)?(s|sec|seconds?|ms|[uµμ]s|ns)[)\]]?)?"
)
"""Names of columns of times, with their unit."""
_STILL, _FEW_MISSING = 1e-9, 0.1
"""Relative range of a constant column: rounding; share of rows without a number that loses a column.
By hand."""
_JUMP, _GAP = 150.0, 45.0
"""Degrees beyond which angles jump at ±180°, and the gap by which their circle can be opened. By hand."""


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
            f"{len(held)} columns of {table.name} name images: {', '.join(held[:5])}.",
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
        remedies = dict.fromkeys(error.remedy for error in doubts)
        raise PalpateError(" ".join(error.problem for error in doubts), " ".join(remedies), code=doubts[0].code)
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


def find_gaps(table: RecordingTable, choice: ColumnMapping) -> tuple[NDArray[np.bool_], str]:
    """Rows (n,) in which a few numbers of the pose are missing, and a sentence; empty without such rows."""
    gaps, names = np.zeros(len(table), bool), []
    asked = {text.partition("=")[0].strip().casefold() for text in choice.targets}
    for name, values in table.columns.items():
        short = short_name(split_unit(name.strip().lower())[0])
        wanted = name.casefold() in asked if asked else AXES.get(short, short) in ("rx", "ry", "depth")
        if wanted and table.is_numeric(name) and name not in table.faults:
            missing = ~np.isfinite(as_numbers(values))
            if 0 < missing.sum() <= _FEW_MISSING * len(values):
                gaps |= missing
                names.append(name)
    if not 0 < gaps.sum() <= _FEW_MISSING * len(gaps):
        return np.zeros(len(table), bool), ""
    return gaps, f"{gaps.sum()} of {len(gaps)} rows are left out: without a number in {', '.join(names)}"


def _rename(table: RecordingTable, learn: tuple[str, ...]) -> tuple[RecordingTable, tuple[str, ...]]:
    """The table with columns by the names that the user gives them, ``pose_4=rx_deg``; these names."""
    pairs = [text.partition("=") for text in learn]
    new = {_given(table, old.strip(), "--targets"): name.strip() for old, mark, name in pairs if mark}
    units = {old: split_unit(old.strip())[1] for old, name in new.items() if not split_unit(name)[1]}
    new |= {old: f"{new[old]} [{unit}]" for old, unit in units.items() if unit and new[old]}
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
    if name.strip().lower() in INDEX or TIME.fullmatch(name.strip().lower()):
        return "it numbers the rows"
    step = np.diff(known)
    if len(known) > 10 and np.all(step == 1.0):
        return "it counts the rows"
    return ""


def _names_images(table: RecordingTable, name: str) -> bool:
    if table.is_numeric(name):
        return False
    first = [text for text in table.columns[name][:50].tolist() if text]
    return bool(first) and all(PurePosixPath(text).suffix.lower() in IMAGE_SUFFIXES for text in first)


def _given(table: RecordingTable, name: str, flag: str) -> str:
    low = name.strip().lower()
    alike = [column for column in table.columns if column.strip().lower() == low]
    bare = [column for column in table.columns if split_unit(column.strip().lower())[0] == low]
    alike = alike or (bare if len(bare) == 1 else [])
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
