"""Predictions as a table: read, and refused in one sentence where it is not what can be judged."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError, wrap_write_errors
from palpate.core.report import write_csv

POSE = ("rx_deg", "ry_deg", "depth_mm")
FORCE = "force_n"
_HEAD = "Write image, rx_deg, ry_deg, depth_mm, and if wished force_n and half_rx_deg, half_ry_deg, half_depth_mm."


def half_width_column(name: str) -> str:
    """Column of the half-width of another column's interval."""
    return f"half_{name}"


KNOWN = ("image", *POSE, FORCE, *(half_width_column(name) for name in (*POSE, FORCE)))
"""Columns that a table may have."""


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
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            head = [name.strip() for name in next(reader, [])]
            _check_head(path, head)
            rows = [_numbers(path, line, head, row) for line, row in enumerate(reader, start=2) if row]
    except (OSError, ValueError, csv.Error) as error:
        raise PalpateError(f"{path} is no table that can be read.", _HEAD, code="table-unreadable") from error
    if not rows:
        raise PalpateError(f"{path} has no row.", _HEAD, code="table-empty")
    table = np.array(rows).T
    values = dict(zip(head, table, strict=True))
    return Predictions(values.pop("image").astype(int), values)


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


def _check_head(path: Path, head: Sequence[str]) -> None:
    missing = [name for name in ("image", *POSE) if name not in head]
    if missing:
        raise PalpateError(f"{path} has no column {missing[0]}.", _HEAD, code="column-missing")
    strange = [name for name in head if name not in KNOWN]
    if strange:
        raise PalpateError(f"{path} has a column '{strange[0]}', which is not known.", _HEAD, code="column-unknown")
    if len(set(head)) < len(head):
        raise PalpateError(f"{path} has a column twice.", _HEAD, code="column-twice")


def _numbers(path: Path, line: int, head: Sequence[str], row: Sequence[str]) -> list[float]:
    if len(row) != len(head):
        raise PalpateError(
            f"Line {line} of {path} has {len(row)} values under {len(head)} names.",
            "Mend the line.",
            code="row-length-wrong",
        )
    found = []
    for name, text in zip(head, row, strict=True):
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise PalpateError(
                f"Line {line} of {path}: {name} is '{text[:20]}', no number.",
                "Give every value.",
                code="value-not-number",
            )
        if name == "image" and (value != int(value) or not 0 <= value < 2**53):
            raise PalpateError(
                f"Line {line} of {path}: '{text[:20]}' is no image.",
                "Take the numbers of test.csv.",
                code="prediction-not-image",
            )
        if name.startswith("half_") and value < 0:
            raise PalpateError(
                f"Line {line} of {path}: {name} is {value:g}.",
                "A half-width is not negative.",
                code="half-width-negative",
            )
        found.append(value)
    return found
