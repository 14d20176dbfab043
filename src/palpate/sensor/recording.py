"""Recorded presses with known poses: a table of the truth, beside images or readings of them.

    image,press,rx_deg,ry_deg,depth_mm
    000.png,rest,,,
    001.png,1,5.0,0.0,0.8

`image` is a file's name, or the number that `palpate sensor live` gave to the image; rows whose press is ``rest``
show the untouched dome. The depth may be on any scale (see `palpate.sensor.depth_zero`), or left empty where nobody
knows it. A column ``force_n``, a load cell's reading along the wall's normal, may be there and may have gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, TextArray
from palpate.datasets import (
    REST,
    ColumnMapping,
    RecordingTable,
    find_image_column,
    find_press_column,
    find_quantities,
    read_table,
    to_surface,
)
from palpate.design import TILT_SPACE

_TRUTH = ("image", "press", *TILT_SPACE.names)
_AXES = ("rx", "ry", "depth")
_EXAMPLE = f"Give a CSV with the columns {', '.join(_TRUTH)}."


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """Known poses of recorded images.

    Attributes
    ----------
    rest
        Images of the untouched dome.
    images
        (n,) images of presses, in order.
    press
        (n,) number of the press, from 0 in the order in which they come.
    poses
        (n, 3) rx, ry (degrees) and depth (mm; NaN where it is not known).
    forces
        (n,) N on the wall along its normal; NaN where it was not measured.
    """

    rest: tuple[str, ...]
    images: tuple[str, ...]
    press: IntArray
    poses: FloatArray
    forces: FloatArray


def read_ground_truth(path: Path, choice: ColumnMapping | None = None) -> GroundTruth:
    """Read the table of the truth.

    Raises
    ------
    PalpateError
        If it cannot be read, lacks a column, or a pose is not a number; the message names the line.
    """
    table, choice = read_table(path), choice or ColumnMapping()
    image = find_image_column(table, choice)
    by = find_press_column(table, choice)
    if not by:
        raise PalpateError(f"{path.name} has no column of presses.", _EXAMPLE, code="column-missing")
    names, numbers = _texts(table, image), _texts(table, by)
    at_rest = np.char.lower(numbers) == REST
    if at_rest.all():
        raise PalpateError(f"{path.name} has no press.", _EXAMPLE, code="recording-no-press")
    pressed = to_surface(table.rows(~at_rest), choice, (image, by))
    found = find_quantities(pressed, choice, (image, by), _AXES, ("force",))
    poses = np.stack([found[axis].values for axis in _AXES], axis=1)
    missing = np.flatnonzero(~np.isfinite(poses[:, :2]).all(axis=1))
    if len(missing):
        raise PalpateError(
            f"{path.name}, line {table.first_line + int(np.flatnonzero(~at_rest)[missing[0]])}: an angle is missing.",
            "Only the depth may be unknown.",
            code="angle-missing",
        )
    order = list(dict.fromkeys(numbers[~at_rest].tolist()))
    press = np.array([order.index(number) for number in numbers[~at_rest].tolist()])
    rest, images = (tuple(names[rows].tolist()) for rows in (at_rest, ~at_rest))
    forces = found["force"].values if "force" in found else np.full(len(images), np.nan)
    return GroundTruth(rest, images, press, poses, forces)


def _texts(table: RecordingTable, name: str) -> TextArray:
    """Cells of a column as text; whole numbers without a decimal point."""
    values = table.columns[name]
    return np.array([f"{value:.15g}" for value in values] if table.is_numeric(name) else values.tolist(), str)


def read_readings(path: Path, truth: GroundTruth) -> tuple[FloatArray, BoolArray]:
    """Read what `palpate sensor live --out` wrote about the images of a truth.

    Returns
    -------
    FloatArray, ndarray of bool
        (n, 3) poses, NaN without one, and (n,) whether the reading is flagged.

    Raises
    ------
    PalpateError
        If the file cannot be read, or an image of the truth has no reading.
    """
    table = read_table(path)
    image = find_image_column(table, ColumnMapping())
    names = _texts(table, image)
    rows = {name: at for at, name in enumerate(names.tolist())}
    missing = [name for name in truth.images if name not in rows]
    if missing:
        raise PalpateError(
            f"{len(missing)} images of the truth have no reading in {path.name}, the first is {missing[0]}.",
            "Number the images as palpate sensor live does: from 1, images at rest not counted.",
            code="readings-missing",
        )
    chosen = table.rows(np.array([rows[name] for name in truth.images]))
    found = find_quantities(chosen, ColumnMapping(), (image,), _AXES)
    flags = [name for name in table.columns if name == "flags" or name.startswith("flags_")]
    flagged = np.zeros(len(chosen), bool)
    for name in flags:
        flagged |= np.array([text not in ("", "[]", "nan", "None") for text in _texts(chosen, name)])
    return np.stack([found[axis].values for axis in _AXES], axis=1), flagged
