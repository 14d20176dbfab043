"""Recorded presses with known poses: a table of the truth, beside images or readings of them.

    image,press,rx_deg,ry_deg,depth_mm
    000.png,rest,,,
    001.png,1,5.0,0.0,0.8

`image` is a file's name, or the number that `palpate sensor live` gave to the image; rows whose press is ``rest``
show the untouched dome. The depth may be on any scale (see `palpate.sensor.depth_zero`), or left empty where nobody
knows it. A column ``force_n``, a load cell's reading along the wall's normal, may be there and may have gaps.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError
from palpate.design import TILT_SPACE

REST = "rest"
_ESTIMATE = TILT_SPACE.names
_TRUTH = ("image", "press", *_ESTIMATE)
_FORCE = "force_n"
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


def read_ground_truth(path: Path) -> GroundTruth:
    """Read the table of the truth.

    Raises
    ------
    PalpateError
        If it cannot be read, lacks a column, or a pose is not a number; the message names the line.
    """
    rows = list(_read_rows(path))
    rest = tuple(row["image"] for _, row in rows if row["press"].strip() == REST)
    pressed = [(line, row) for line, row in rows if row["press"].strip() != REST]
    if not pressed:
        raise PalpateError(f"{path.name} has no press.", _EXAMPLE, code="recording-no-press")
    poses = np.array([[_number(path, line, row, name) for name in _ESTIMATE] for line, row in pressed])
    for (line, _), pose in zip(pressed, poses, strict=True):
        if not np.isfinite(pose[:2]).all():
            raise PalpateError(
                f"{path.name}, line {line}: an angle is missing.",
                "Only the depth may be unknown.",
                code="angle-missing",
            )
    names = list(dict.fromkeys(row["press"] for _, row in pressed))
    press = np.array([names.index(row["press"]) for _, row in pressed])
    forces = np.array([_number(path, line, row, _FORCE) for line, row in pressed])
    return GroundTruth(rest, tuple(row["image"] for _, row in pressed), press, poses, forces)


def read_readings(path: Path, truth: GroundTruth) -> tuple[FloatArray, BoolArray]:
    """Read what `palpate sensor live --out` wrote about the images of a truth.

    Returns
    -------
    FloatArray, ndarray of bool
        (n, 3) poses, NaN where there is none, and (n,) whether the reading is flagged.

    Raises
    ------
    PalpateError
        If the file cannot be read, or an image of the truth has no reading.
    """
    rows = {str(row["image"]): row for row in _read_any(path)}
    missing = [name for name in truth.images if name not in rows]
    if missing:
        raise PalpateError(
            f"{len(missing)} images of the truth have no reading in {path.name}, the first is {missing[0]}.",
            "Number the images as palpate sensor live does: from 1, images at rest not counted.",
            code="readings-missing",
        )
    chosen = [rows[name] for name in truth.images]
    try:
        poses = np.array([[_or_nan(row[name]) for name in _ESTIMATE] for row in chosen])
    except (KeyError, ValueError, TypeError) as error:
        raise PalpateError(
            f"{path.name} holds no readings: {error}.",
            "Give what palpate sensor live --out wrote.",
            code="readings-unreadable",
        ) from error
    return poses, np.array([bool(row.get("flags")) for row in chosen])


def _read_rows(path: Path) -> Iterator[tuple[int, dict[str, str]]]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            table = csv.DictReader(file)
            absent = [name for name in _TRUTH if name not in (table.fieldnames or ())]
            if absent:
                raise PalpateError(f"{path.name} has no column {', '.join(absent)}.", _EXAMPLE, code="column-missing")
            for row in table:
                yield table.line_num, {name: row.get(name) or "" for name in (*_TRUTH, _FORCE)}
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise PalpateError(f"{path} cannot be read: {error}.", _EXAMPLE, code="file-unreadable") from error


def _number(path: Path, line: int, row: dict[str, str], name: str) -> float:
    try:
        return _or_nan(row[name])
    except ValueError:
        raise PalpateError(
            f"{path.name}, line {line}: {name} is '{row[name]}'.", "Write a number.", code="value-not-number"
        ) from None


def _or_nan(value: Any) -> float:
    return float("nan") if value in ("", None) else float(value)


def _read_any(path: Path) -> list[dict[str, Any]]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            if path.suffix == ".jsonl":
                return [json.loads(line) for line in file if line.strip()]
            return list(csv.DictReader(file))
    except (OSError, ValueError, csv.Error) as error:
        raise PalpateError(
            f"{path} cannot be read: {error}.", "Give what palpate sensor live --out wrote.", code="file-unreadable"
        ) from error
