"""Poses of a robot's tool as poses relative to the surface that it presses.

A tool that points down has rotation vectors and Euler angles near ±180°, which jump there; its tilt relative to the
surface does not. The tilt is the rotation vector of R in ``R0 R``, R0 the tool's orientation normal to the surface.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray, PalpateError
from palpate.core.files import natural_key
from palpate.core.units import split_unit
from palpate.datasets.column_mapping import ColumnMapping
from palpate.datasets.pose_column import FACTORS, PoseColumn, short_name
from palpate.datasets.quantities import find_angles_and_lengths
from palpate.datasets.recording_columns import list_columns
from palpate.datasets.table import RecordingTable, as_numbers

_EULER = ("roll", "pitch", "yaw")
_ROBOTS = {("A", "B", "C"): ("yaw", "pitch", "roll"), ("W", "P", "R"): ("roll", "pitch", "yaw")}
"""Letters of angles in poses XYZABC of KUKA and XYZWPR of FANUC → angles about fixed axes."""
_TCP = {
    "actual_TCP_pose_": "x_m y_m z_m rx_rad ry_rad rz_rad",
    "eef?_pos_": "x_m y_m z_m",
    "(?:position|translation)_": "x y z",
    "(?:rotation|rotvec|rvec|rotation_vector|axis_angle)_": "rx ry rz",
}
"""Beginnings of numbered columns of Universal Robots, robomimic, robosuite and JSON → their names."""
_AXES = {"x", "y", "z", "depth", "rx", "ry", "rz"}
"""Axes of a pose."""
_QUATERNION = re.compile(r"(?:^|[_. ])(?:q|quat|quaternion|orientation|rot|rotation|ori)[_. \[]*([wxyz]|\d)\]?$")
_MATRIX = re.compile(r"^(.*?)[_. ]*\[?([0-4])[\]_, ]*\[?([0-4])\]?$")
_NEAR_AXIS = 8.0
"""Degrees from the mean tool axis to a base axis up to which the surface is normal to this axis:
the mean of 12 tilts of 10° strays by 3°, and a surface set up by hand by 2°."""
_SPREAD = 75.0
"""Maximum degrees from a tool axis to the mean of presses on one surface. By hand."""
_TURNED = 90.0
"""Angles up to it (degrees) may be tilts: columns rx and ry are then no tool orientation. By hand."""
_UNIT_NORM = 0.02
"""Maximum deviation of a quaternion's norm from 1, for rounding to two decimals."""
_FLAGS = "Give --orientation rotvec, xyzw, wxyz, matrix or an order of Euler angles such as xyz, and --frame."


@dataclass(frozen=True, eq=False)
class _Found:
    """Orientations (n), their columns, their kind, and positions (n, 3) in mm or `None`."""

    turns: Rotation
    columns: tuple[str, ...]
    kind: str
    positions: FloatArray | None = None


def to_surface(table: RecordingTable, choice: ColumnMapping, taken: tuple[str, ...]) -> RecordingTable:
    """The table with rx_deg, ry_deg and depth_mm relative to the surface, if poses are in a base.

    Parameters
    ----------
    table, choice
        The table, and the statements of the user on it.
    taken
        Columns of images and presses.

    Raises
    ------
    PalpateError
        If the representation of the orientation, or the surface, is not known; the remedy names the flag.
    """
    if any("=" in text for text in choice.targets):
        return table
    given, tool = table, _name_tcp(table, choice, taken)
    table = _name_robot_angles(tool, choice, taken)
    if "rx_rad" in tool.columns and "rx_rad" not in given.columns:  # the robot's orientation has one kind
        choice = replace(choice, euler=choice.euler or "rotvec")
    doubts: list[PalpateError] = []
    angles = find_angles_and_lengths(table, choice, taken, doubts)
    found = _quaternions(table, choice) or _matrices(table, choice) or _three_angles(table, angles, choice)
    if found is None and choice.euler:
        raise (
            doubts[0]
            if doubts
            else PalpateError(
                f"No columns of {table.name} are an orientation {choice.euler}; it has {list_columns(table)}.",
                "Name them rx, ry, rz, or qx to qw, or r11 to r33, or leave out --orientation.",
                code="euler-columns-missing",
            )
        )
    frame = _frame(choice.frame)
    if found is None and frame is None:  # z of a base is no depth
        return table if tool is given else given
    axis, inward, notes = _surface(found, frame)
    new: dict[str, FloatArray] = {}
    if found is not None:
        spread = float((found.turns.as_matrix()[:, :, 2] @ axis).min())
        relative = frame is None and axis[2] > max(0.5, spread)  # tilts about the surface surround its normal
        new = dict(zip(("rx_deg", "ry_deg"), _tilt(found.turns, axis, relative).T, strict=True))
        where = "in the frame of the poses" if relative else "in the tool's frame"
        notes.insert(
            0,
            f"Columns {', '.join(found.columns)} are read as {found.kind}, and rx and ry are the tilt's rotation "
            f"vector relative to the surface, {where}.",
        )
        if relative:
            inward = None
    places = found.positions if found is not None and found.positions is not None else _positions(angles)
    used = set(found.columns) if found is not None else set()
    height = angles.get("depth")
    if frame is not None and places is None and height is not None and short_name(height.column.lower())[:1] == "z":
        raise PalpateError(
            f"--frame is given, but {table.name} has a height {height.column} without x and y in mm or m.",
            "Add them, or leave out --frame and give the depth.",
            code="positions-missing",
        )
    if inward is not None and places is not None and "depth_mm" not in table.columns:
        depth = (places - (0.0 if frame is None else frame[0])) @ inward
        used |= {one.column for axis_name, one in angles.items() if axis_name == "depth" and one.unit == "mm"}
        if frame is None:
            depth = depth - depth.min()
            notes.append("The depth is counted along the normal from the shallowest image; --frame sets it.")
        new["depth_mm"] = depth
    columns = {name: values for name, values in table.columns.items() if name not in used and name not in new}
    return replace(table, columns={**columns, **new}, notes=(*table.notes, *notes))


def _name_tcp(table: RecordingTable, choice: ColumnMapping, taken: tuple[str, ...]) -> RecordingTable:
    """The table with names of axes for numbered columns of one tool (`_TCP`), unless others name an axis."""
    named = choice.targets or find_angles_and_lengths(table, choice, taken).keys() & _AXES
    for start, names in _TCP.items() if not named else ():
        found = [name for name in table.columns if re.fullmatch(rf"(.*[_.])?{start}\d", name, re.I)]
        axes = (names.replace("_m", "") if choice.lengths else names).split()
        if len(found) == len(axes):
            table = _rename(table, dict(zip(sorted(found), axes, strict=True)), axes)
    return table


def _name_robot_angles(table: RecordingTable, choice: ColumnMapping, taken: tuple[str, ...]) -> RecordingTable:
    """The table with roll, pitch and yaw as names of angles that have letters of a robot (`_ROBOTS`)."""
    bare = {
        split_unit(name.strip())[0]: name for name in table.columns if table.is_numeric(name) and name not in taken
    }
    named = {short_name(name.lower()) for name in bare} & {"roll", "pitch", "yaw", "rx", "ry", "rz"}
    for letters, words in _ROBOTS.items() if not (choice.targets or named) else ():
        if all(letter in bare for letter in (*letters, *"XYZ")):
            units = [split_unit(bare[letter].strip())[1].lower() for letter in letters]
            if any(unit and FACTORS.get(unit, ("", 0.0))[0] != "deg" for unit in units):
                continue
            new = {bare[a]: f"{b} ({unit})" if unit else b for a, b, unit in zip(letters, words, units, strict=True)}
            return _rename(table, new, words)
    return table


def _rename(table: RecordingTable, new: Mapping[str, str], words: Sequence[str]) -> RecordingTable:
    """The table with new names of columns, which a note states as these words."""
    columns = {new.get(name, name): values for name, values in table.columns.items()}
    faults = {new.get(name, name): fault for name, fault in table.faults.items()}
    note = f"Columns {', '.join(new)} are read as {', '.join(words)}"
    return replace(table, columns=columns, faults=faults, notes=(*table.notes, note))


def _frame(text: str) -> tuple[FloatArray, FloatArray] | None:
    """Point of the surface, mm, and its outward unit normal."""
    if not text:
        return None
    try:
        numbers = np.array([float(part) for part in text.replace(";", ",").split(",")])
    except ValueError:
        numbers = np.empty(0)
    if len(numbers) != 6 or not np.isfinite(numbers).all() or not np.linalg.norm(numbers[3:]) > 0:
        raise PalpateError(
            f"--frame is '{text}'.",
            "Give a point of the surface in mm and its outward normal: x,y,z,nx,ny,nz, such as 400,-100,200,0,0,1.",
            code="frame-unreadable",
        )
    return numbers[:3], numbers[3:] / np.linalg.norm(numbers[3:])


def _surface(
    found: _Found | None, frame: tuple[FloatArray, FloatArray] | None
) -> tuple[FloatArray, FloatArray | None, list[str]]:
    """Tool axis normal to the surface, direction into the surface, and notes on an estimate of them."""
    if found is None:
        assert frame is not None
        return -frame[1], -frame[1], []
    axes = found.turns.as_matrix()[:, :, 2]
    mean = axes.mean(axis=0)
    mean = mean / max(float(np.linalg.norm(mean)), 1e-12)
    if frame is not None:
        mean = np.sign(mean @ frame[1] or 1.0) * frame[1]
    spread = float(np.degrees(np.arccos(np.clip(axes @ mean, -1, 1))).max())
    if spread > _SPREAD:
        raise PalpateError(
            f"Read as {found.kind}, the tool's axis turns by {spread:.0f}° from its mean: no presses on one surface.",
            _FLAGS,
            code="orientation-spread",
        )
    if frame is not None:
        return mean, -frame[1], []
    nearest = np.zeros(3)
    nearest[np.argmax(np.abs(mean))] = np.sign(mean[np.argmax(np.abs(mean))])
    off = float(np.degrees(np.arccos(np.clip(mean @ nearest, -1, 1))))
    if off <= _NEAR_AXIS:
        name = ("+" if nearest.sum() > 0 else "-") + "xyz"[int(np.argmax(np.abs(nearest)))]
        return nearest, nearest, [f"The surface is taken as normal to {name} (mean tool axis: {off:.1f}° from it)."]
    text = ", ".join(f"{value:.3f}" for value in mean)
    return mean, mean, [f"The surface is taken as normal to the mean tool axis ({text}); --frame states it."]


def _tilt(turns: Rotation, axis: FloatArray, relative: bool) -> FloatArray:
    """(n, 2) degrees: rotation vector of the tilt, without the turn about the normal."""
    if relative:
        normal = turns.as_matrix()[:, :, 2]
        across = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    else:
        normal = turns.inv().apply(axis)
        across = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    size = np.hypot(across[:, 0], across[:, 1])
    return np.asarray(across * (np.degrees(np.arctan2(size, normal[:, 2])) / np.maximum(size, 1e-12))[:, None])


def _positions(angles: dict[str, PoseColumn]) -> FloatArray | None:
    names = ("x", "y", "depth")
    if not all(name in angles and angles[name].unit == "mm" for name in names):
        return None
    places = np.stack([angles[name].values for name in names], axis=1)
    return (
        places if np.isfinite(places).all() and split_unit(angles["depth"].column.lower())[0].endswith("z") else None
    )


def _finite(table: RecordingTable, columns: list[str]) -> FloatArray:
    """(n, k) numbers of columns, all of them finite."""
    values = np.stack([as_numbers(table.columns[name]) for name in columns], axis=1)
    if not np.isfinite(values).all():
        raise PalpateError(
            f"{table.name}: an orientation has an empty cell in {', '.join(columns)}.",
            "Fill the cell or leave out the row.",
            code="cell-empty",
        )
    return values


def _quaternions(table: RecordingTable, choice: ColumnMapping) -> _Found | None:
    """Four columns of a unit quaternion, by letters, or by numbers in an order that the user states."""
    keys: dict[str, str] = {}
    for name in table.columns:
        match = _QUATERNION.search(split_unit(name.strip().lower())[0])
        if match and table.is_numeric(name):
            keys.setdefault(match[1], name)
    numbered = sorted(key for key in keys if key.isdigit())
    if {"w", "x", "y", "z"} <= set(keys):
        columns, order = [keys[letter] for letter in "xyzw"], "xyzw"
    elif len(numbered) == 4:
        columns, order = [keys[key] for key in numbered], choice.euler
    else:
        return None
    values = _finite(table, columns)
    if np.abs(np.linalg.norm(values, axis=1) - 1).max() > _UNIT_NORM:
        return None
    if order not in ("xyzw", "wxyz"):
        raise PalpateError(
            f"Columns {', '.join(columns)} are a quaternion, and their names do not state its order.",
            "Give --orientation xyzw or --orientation wxyz.",
            code="orientation-unknown",
        )
    values = values if order == "xyzw" else values[:, [1, 2, 3, 0]]
    return _Found(Rotation.from_quat(values), tuple(columns), f"a quaternion ({order})")


def _matrices(table: RecordingTable, choice: ColumnMapping) -> _Found | None:
    """Nine columns of a rotation matrix, or those of a homogeneous one with the position."""
    groups: dict[str, dict[tuple[int, int], str]] = {}
    rows: dict[str, list[str]] = {}
    for name in filter(table.is_numeric, table.columns):
        if match := _MATRIX.match(name.strip().lower()):
            groups.setdefault(match[1], {})[int(match[2]), int(match[3])] = name
        rows.setdefault(re.sub(r"[_. ]*\[?\d+\]?$", "", name), []).append(name)
    for start, names in rows.items():
        if len(names) == 16:
            grid = np.array(sorted(names, key=natural_key)).reshape(4, 4)
            by_columns = not any(table.columns[name].any() for name in grid[:3, 3].tolist())  # as Franka's O_T_EE
            groups[start] = {place: str(name) for place, name in np.ndenumerate(grid.T if by_columns else grid)}
    for group in groups.values():
        first = 0 if (0, 0) in group else 1
        places = [(i + first, j + first) for i in range(3) for j in range(3)]
        if not all(place in group for place in places):
            continue
        columns = [group[place] for place in places]
        values = _finite(table, columns).reshape(-1, 3, 3)
        if (
            np.abs(values @ values.swapaxes(1, 2) - np.eye(3)).max() > 2 * _UNIT_NORM
            or np.linalg.det(values).min() < 0
        ):
            continue
        last = [group.get((i + first, 3 + first), "") for i in range(3)]
        positions = None
        if all(last):
            where = _finite(table, last)
            unit = choice.lengths or ("mm" if np.abs(where).max() > 10 else "m")
            positions = where * (1e3 if unit == "m" else 1.0)
        return _Found(Rotation.from_matrix(values), tuple(group.values()), "a rotation matrix", positions)
    return None


def _three_angles(table: RecordingTable, angles: dict[str, PoseColumn], choice: ColumnMapping) -> _Found | None:
    """Rotation vector or Euler angles, if the user states them or a tool is turned by more than 90°."""
    chosen = [angles[axis] for axis in ("rx", "ry", "rz") if axis in angles and angles[axis].unit == "deg"]
    axes = [one.axis for one in chosen]
    if "rx" not in axes or "ry" not in axes:
        return None
    columns = tuple(one.column for one in chosen)
    values = np.stack([one.values for one in chosen], axis=1)
    if len(chosen) == 2:
        values = np.column_stack([values, np.zeros(len(values))])
    kind = choice.euler
    if not kind:
        known = np.abs(values[:, :2])
        if not np.isfinite(values).all() or known.max() <= _TURNED:
            return None
        kind = _guess(table, chosen, values)
    if not np.isfinite(values).all():
        _finite(table, list(columns))
    if kind == "rotvec":
        return _Found(Rotation.from_rotvec(values, degrees=True), columns, "a rotation vector")
    if sorted(kind.lower()) != ["x", "y", "z"] or kind not in (kind.lower(), kind.upper()):
        raise PalpateError(f"'{kind}' is no orientation of three angles.", _FLAGS, code="euler-order-unknown")
    places = {"x": 0, "y": 1, "z": 2}
    turns = Rotation.from_euler(kind, values[:, [places[letter] for letter in kind.lower()]], degrees=True)
    return _Found(turns, columns, f"Euler angles in the order {kind}")


def _guess(table: RecordingTable, chosen: list[PoseColumn], values: FloatArray) -> str:
    """Kind of three angles by names and size: rotation vectors are in radians, at most pi long."""
    names = tuple(short_name(split_unit(one.column.lower())[0]) for one in chosen)
    if names == _EULER[: len(names)]:
        return "xyz"
    longest = float(np.linalg.norm(values, axis=1).max())
    radians = all(split_unit(one.column.lower())[1] in ("rad", "radian", "radians") for one in chosen)
    if radians and len(chosen) == 3 and longest <= 180.5:
        return "rotvec"
    raise PalpateError(
        f"{table.name}: {', '.join(one.column for one in chosen)} turn by up to {longest:.0f}°, so they jump: "
        "a rotation vector or Euler angles of a tool that is turned over.",
        _FLAGS,
        code="orientation-unknown",
    )
