"""Tables of predictions: reading with validation, selection of images, and writing."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError, wrap_write_errors
from palpate.core.report import write_csv
from palpate.datasets import ColumnMapping, find_image_column, find_quantities, read_table

POSE = ("rx_deg", "ry_deg", "depth_mm")
FORCE = "force_n"
_HEAD = (
    "Give the columns image, rx_deg, ry_deg, depth_mm; optional: force_n and half_NAME of each, as in half_rx_deg."
)


def half_width_column(name: str) -> str:
    """Return the name of the half-width column that belongs to a column."""
    return f"half_{name}"


KNOWN = ("image", *POSE, FORCE, *(half_width_column(name) for name in (*POSE, FORCE)))
"""Columns that a table may contain."""


_AXES = ("rx", "ry", "depth")
_COLUMN = dict(zip((*_AXES, "force"), (*POSE, FORCE), strict=True))
_COLUMN |= {f"half_{axis}": half_width_column(name) for axis, name in _COLUMN.items()}
_OPTIONAL = tuple(axis for axis in _COLUMN if axis not in _AXES)


@dataclass(frozen=True, eq=False)
class Predictions:
    """Predicted values by image.

    Attributes
    ----------
    image
        (n,) numbers.
    values
        (n,) by column of `KNOWN`; the columns of `POSE` are always present.
    """

    image: IntArray
    values: dict[str, FloatArray]

    def rows(self, wanted: IntArray, called: str) -> Predictions:
        """Return the predictions of exactly the wanted images, in their order.

        Parameters
        ----------
        wanted
            (k,) image numbers, each once.
        called
            Name of these images in messages.

        Raises
        ------
        PalpateError
            If an image is missing, repeated or not wanted.
        """
        numbers, counts = np.unique(self.image, return_counts=True)
        doubles, strange = numbers[counts > 1], np.setdiff1d(numbers, wanted)
        missing = np.setdiff1d(wanted, numbers)
        if len(doubles):
            raise PalpateError(
                f"{len(doubles)} images are predicted more than once, image {doubles[0]} among them.",
                "Give each image exactly one row.",
                code="prediction-twice",
            )
        if len(strange):
            raise PalpateError(
                f"{len(strange)} predicted images do not belong to {called}, image {strange[0]} among them.",
                "Take the numbers of test.csv.",
                code="prediction-image-unknown",
            )
        if len(missing):
            raise PalpateError(
                f"{len(missing)} of the {len(wanted)} images of {called} have no prediction, image {missing[0]} "
                "among them.",
                "Predict every image, or give --track pictures to score the rendered images only.",
                code="predictions-missing",
            )
        order = np.argsort(self.image)[np.searchsorted(np.sort(self.image), wanted)]
        return Predictions(self.image[order], {name: value[order] for name, value in self.values.items()})


def read_predictions(path: Path) -> Predictions:
    """Read a table of predictions.

    Raises
    ------
    PalpateError
        If the file cannot be read, lacks a column, has an unknown one, or contains an invalid value.
    """
    table = read_table(path)
    image = find_image_column(table, ColumnMapping())
    found = find_quantities(table, ColumnMapping(), (image,), _AXES, _OPTIONAL)
    strange = [name for name in table.columns if name not in (image, *(one.column for one in found.values()))]
    if strange:
        raise PalpateError(f"{path} has an unknown column '{strange[0]}'.", _HEAD, code="column-unknown")
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
        If the file cannot be written.
    """
    names = [name for name in KNOWN if name in predictions.values]
    columns = [np.round(predictions.values[name], 6).tolist() for name in names]
    with wrap_write_errors(path):
        write_csv(path, zip(predictions.image.tolist(), *columns, strict=True), ("image", *names))


def _check(path: Path, line: int, name: str, cells: FloatArray) -> None:
    """Reject missing values, invalid image numbers, and negative half-widths."""
    wrong = ~np.isfinite(cells) if cells.dtype.kind == "f" else np.ones(len(cells), bool)
    if wrong.any():
        at = int(np.argmax(wrong))
        raise PalpateError(
            f"Line {line + at} of {path}: {name} is '{cells[at]}', which is not a number.",
            "Give a number in every row.",
            code="value-not-number",
        )
    if name == "image" and (bad := (cells != np.floor(cells)) | (cells < 0) | (cells >= 2**53)).any():
        at = int(np.argmax(bad))
        raise PalpateError(
            f"Line {line + at} of {path}: '{cells[at]:g}' is not an image number.",
            "Take the numbers of test.csv.",
            code="prediction-not-image",
        )
    if name.startswith("half_") and (cells < 0).any():
        at = int(np.argmax(cells < 0))
        raise PalpateError(
            f"Line {line + at} of {path}: {name} is {cells[at]:g}; it must not be negative.",
            "Give half-widths of at least 0.",
            code="half-width-negative",
        )
