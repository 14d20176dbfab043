"""Recorded presses of known pose: a table of ground truth for images or their readings.

    image,press,rx_deg,ry_deg,depth_mm
    000.png,rest,,,
    001.png,1,5.0,0.0,0.8

`image` is a file name, or the number that `palpate sensor live` gave to the image; rows whose press is ``rest`` are
rest images. The depth may be on any scale (see `palpate.sensor.depth_zero`), or empty if unknown. An optional column
``force_n`` holds a load cell's reading along the wall normal; it may have gaps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import read_image
from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, TextArray
from palpate.datasets import (
    REST,
    ColumnMapping,
    RecordingTable,
    find_files,
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
        Rest images.
    images
        (n,) images of presses, in order.
    press
        (n,) index of the press, in order of occurrence.
    poses
        (n, 3) rx, ry (degrees) and depth (mm; NaN if unknown).
    forces
        (n,) force on the wall along its normal, N; NaN if not measured.
    """

    rest: tuple[str, ...]
    images: tuple[str, ...]
    press: IntArray
    poses: FloatArray
    forces: FloatArray

    def locate(self, folder: Path) -> GroundTruth:
        """Return it with the paths of its images, which are in a folder or below it.

        Raises
        ------
        PalpateError
            If none of them exists, or a name is in several folders.
        """
        paths = [str(path) for path in find_files(folder, (*self.rest, *self.images))]
        return replace(self, rest=tuple(paths[: len(self.rest)]), images=tuple(paths[len(self.rest) :]))

    def presses(self) -> Iterator[tuple[FloatArray, list[NDArray[Any]], FloatArray]]:
        """Yield poses, images and forces of each press, of images with a known depth (`identify_unit`).

        Raises
        ------
        PalpateError
            If a press has no depth, or an image cannot be read.
        """
        for number in range(int(self.press.max()) + 1):
            which = np.flatnonzero((self.press == number) & np.isfinite(self.poses[:, 2]))
            if not len(which):
                raise PalpateError(
                    f"Press {number + 1} has no depth.",
                    "Give the robot's depth of its images; the zero of the depth scale is arbitrary.",
                    code="press-depth-missing",
                )
            yield self.poses[which], [read_image(Path(self.images[k])) for k in which], self.forces[which]


def read_ground_truth(path: Path, choice: ColumnMapping | None = None) -> GroundTruth:
    """Read a table of ground truth.

    Raises
    ------
    PalpateError
        If it cannot be read, lacks a column, or a pose is not a number; the message contains the line.
    """
    table, choice = read_table(path), choice or ColumnMapping()
    image = find_image_column(table, choice)
    by = find_press_column(table, choice)
    if not by:
        raise PalpateError(f"{path.name} has no press column.", _EXAMPLE, code="column-missing")
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
            "Give both angles of every image; only the depth may be missing.",
            code="angle-missing",
        )
    order = list(dict.fromkeys(numbers[~at_rest].tolist()))
    press = np.array([order.index(number) for number in numbers[~at_rest].tolist()])
    rest, images = (tuple(names[rows].tolist()) for rows in (at_rest, ~at_rest))
    forces = found["force"].values if "force" in found else np.full(len(images), np.nan)
    return GroundTruth(rest, images, press, poses, forces)


def _texts(table: RecordingTable, name: str) -> TextArray:
    """Return the cells of a column as text, whole numbers without a decimal point."""
    values = table.columns[name]
    return np.array([f"{value:.15g}" for value in values] if table.is_numeric(name) else values.tolist(), str)


def read_readings(path: Path, truth: GroundTruth) -> tuple[FloatArray, BoolArray]:
    """Read the output of `palpate sensor live --out` for the images of a ground truth.

    Returns
    -------
    FloatArray, ndarray of bool
        (n, 3) poses, NaN without one, and (n,) whether the reading is flagged.

    Raises
    ------
    PalpateError
        If the file cannot be read, or an image of the ground truth has no reading.
    """
    table = read_table(path)
    image = find_image_column(table, ColumnMapping())
    names = _texts(table, image)
    rows = {name: at for at, name in enumerate(names.tolist())}
    missing = [name for name in truth.images if name not in rows]
    if missing:
        raise PalpateError(
            f"{len(missing)} images of the ground truth have no reading in {path.name}, the first is {missing[0]}.",
            "Number the images as palpate sensor live does: from 1, without the rest images.",
            code="readings-missing",
        )
    chosen = table.rows(np.array([rows[name] for name in truth.images]))
    found = find_quantities(chosen, ColumnMapping(), (image,), _AXES)
    flags = [name for name in table.columns if name == "flags" or name.startswith("flags_")]
    flagged = np.zeros(len(chosen), bool)
    for name in flags:
        flagged |= np.array([text not in ("", "[]", "nan", "None") for text in _texts(chosen, name)])
    return np.stack([found[axis].values for axis in _AXES], axis=1), flagged
