"""Predictions as a table: read, and refused in one sentence where it is not what can be judged."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError, wrap_write_errors
from palpate.core.report import write_csv
from palpate.datasets import ColumnMapping, find_image_column, find_quantities, read_table

POSE = ("rx_deg", "ry_deg", "depth_mm")
FORCE = "force_n"
_HEAD = "Write image, rx_deg, ry_deg, depth_mm, and if wished force_n and half_rx_deg, half_ry_deg, half_depth_mm."


def half_width_column(name: str) -> str:
    """Column of the half-width of another column's interval."""
    return f"half_{name}"


KNOWN = ("image", *POSE, FORCE, *(half_width_column(name) for name in (*POSE, FORCE)))
"""Columns that a table may have."""


_AXES = ("rx", "ry", "depth")
_COLUMN = dict(zip((*_AXES, "force"), (*POSE, FORCE), strict=True))
_COLUMN |= {f"half_{axis}": half_width_column(name) for axis, name in _COLUMN.items()}
_OPTIONAL = tuple(axis for axis in _COLUMN if axis not in _AXES)


@dataclass(frozen=True, eq=False)
class Predictions:
    """What somebody says about images.

    Attributes
    ----------
    image
        (n,) numbers.
    values
        (n,) by the name of a column of `KNOWN`; those of `POSE` are always there.
    """

    image: IntArray
    values: dict[str, FloatArray]

    def rows(self, wanted: IntArray, called: str) -> Predictions:
        """Those of exactly the wanted images, in their order.

        Parameters
        ----------
        wanted
            (k,) numbers, each once.
        called
            What these images are, for messages.

        Raises
        ------
        PalpateError
            If one is missing, there twice, or not wanted.
        """
        numbers, counts = np.unique(self.image, return_counts=True)
        doubles, strange = numbers[counts > 1], np.setdiff1d(numbers, wanted)
        missing = np.setdiff1d(wanted, numbers)
        if len(doubles):
            raise PalpateError(
                f"{len(doubles)} images are predicted more than once, image {doubles[0]} among them.",
                "Give each image one row.",
                code="prediction-twice",
            )
        if len(strange):
            raise PalpateError(
                f"{len(strange)} predicted images are none of {called}, image {strange[0]} among them.",
                "Take the numbers of test.csv.",
                code="prediction-image-unknown",
            )
        if len(missing):
            raise PalpateError(
                f"{len(missing)} of the {len(wanted)} images of {called} have no prediction, image {missing[0]} "
                "among them.",
                "Predict every image; to be judged by those with a picture alone, give --track pictures.",
                code="predictions-missing",
            )
        order = np.argsort(self.image)[np.searchsorted(np.sort(self.image), wanted)]
        return Predictions(self.image[order], {name: value[order] for name, value in self.values.items()})


def read_predictions(path: Path) -> Predictions:
    """Read a table of predictions.

    Raises
    ------
    PalpateError
        If it cannot be read, lacks a column, has an unknown one, or a value is no number.
    """
    table = read_table(path)
    image = find_image_column(table, ColumnMapping())
    found = find_quantities(table, ColumnMapping(), (image,), _AXES, _OPTIONAL)
    strange = [name for name in table.columns if name not in (image, *(one.column for one in found.values()))]
    if strange:
        raise PalpateError(f"{path} has a column '{strange[0]}', which is not known.", _HEAD, code="column-unknown")
    numbers = table.columns[image]
    values = {_COLUMN[axis]: one.values for axis, one in found.items()}
    for name, cells in {"image": numbers, **values}.items():
        _check(path, table.first_line, name, cells)
    return Predictions(numbers.astype(int), values)


def write_predictions(path: Path, predictions: Predictions) -> None:
    """Write a table of predictions.

    Raises
    ------
    PalpateError
        If it cannot be written.
    """
    names = [name for name in KNOWN if name in predictions.values]
    columns = [np.round(predictions.values[name], 6).tolist() for name in names]
    with wrap_write_errors(path):
        write_csv(path, zip(predictions.image.tolist(), *columns, strict=True), ("image", *names))


def _check(path: Path, line: int, name: str, cells: FloatArray) -> None:
    """Refuse a missing number, an image that is no number, and a half-width below 0."""
    wrong = ~np.isfinite(cells) if cells.dtype.kind == "f" else np.ones(len(cells), bool)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise PalpateError(
            f"Line {line + at} of {path}: {name} is '{cells[at]}', no number.",
            "Give every value.",
            code="value-not-number",
        )
    if name == "image" and (bad := (cells != np.floor(cells)) | (cells < 0) | (cells >= 2**53)).any():
        at = int(np.argmax(bad))
        raise PalpateError(
            f"Line {line + at} of {path}: '{cells[at]:g}' is no image.",
            "Take the numbers of test.csv.",
            code="prediction-not-image",
        )
    if name.startswith("half_") and (cells < 0).any():
        at = int(np.argmax(cells < 0))
        raise PalpateError(
            f"Line {line + at} of {path}: {name} is {cells[at]:g}.",
            "A half-width is not negative.",
            code="half-width-negative",
        )
