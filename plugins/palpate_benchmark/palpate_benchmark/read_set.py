"""Reading of a data set: marker positions, labels and rendered images by split."""

from __future__ import annotations

import csv
import json
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from palpate.camera import decode_image
from palpate.core import FloatArray, IntArray, PalpateError, TextArray, load_opencv, reject_external_links
from palpate_benchmark.set_files import CHECKSUMS, HIDDEN, digest
from palpate_benchmark.spec import BenchmarkSpec, Split
from palpate_benchmark.unit_images import LABELS

_AGAIN = "Give the folder 'set' that palpate benchmark make wrote."


@dataclass(frozen=True, eq=False)
class SplitTable:
    """Labels of one split, one row per image, by ascending image number.

    Attributes
    ----------
    image, unit, press
        (n,) numbers.
    design, picture, branch
        (n,) name of the design, of the rendered image (empty if not rendered), and of the branch.
    labels
        (n, 6) by `LABELS`.
    """

    image: IntArray
    unit: IntArray
    press: IntArray
    design: TextArray
    picture: TextArray
    branch: TextArray
    labels: FloatArray

    def __len__(self) -> int:
        return len(self.image)


@dataclass(frozen=True, eq=False)
class SplitMarkers:
    """Marker positions of one design and split.

    Attributes
    ----------
    image, unit
        (n,) numbers; those of images are ascending.
    markers_px
        (n, m, 2); NaN for a missing marker.
    rest_px
        Rest positions (m, 2) by unit number.
    """

    image: IntArray
    unit: IntArray
    markers_px: FloatArray
    rest_px: dict[int, FloatArray]


@dataclass(frozen=True)
class BenchmarkSet:
    """A data set on disk."""

    folder: Path
    spec: BenchmarkSpec

    def table(self, split: Split) -> SplitTable:
        """Return the labels of one split; those of the test are read from the hidden file.

        Raises
        ------
        PalpateError
            If a table is missing or damaged.
        """
        sight = _read_columns(self.folder / f"{split}.csv")
        told = _read_columns(self.folder / HIDDEN) if split == "test" else sight
        try:
            if told["image"] != sight["image"]:
                raise PalpateError(
                    f"{HIDDEN} and {split}.csv have different image numbers.", _AGAIN, code="benchmark-images-differ"
                )
            return SplitTable(
                image=np.array(sight["image"], int),
                unit=np.array(sight["unit"], int),
                press=np.array(told["press"], int),
                design=np.array(sight["design"]),
                picture=np.array(sight["picture"]),
                branch=np.array(told["branch"]),
                labels=np.array([told[name] for name in LABELS], float).T,
            )
        except (KeyError, OverflowError, ValueError) as error:
            raise PalpateError(
                f"The tables of {split} in {self.folder} are damaged: {error}.",
                _AGAIN,
                code="benchmark-table-damaged",
            ) from error

    def markers(self, split: Split, design: str) -> SplitMarkers:
        """Return the marker positions of one design and split.

        Raises
        ------
        PalpateError
            If the file is missing or damaged.
        """
        path = self.folder / f"{split}.h5"
        try:
            with h5py.File(path, "r") as file:
                reject_external_links(file, path)
                kept = file[design]
                rest = zip(kept["rest_unit"][()].tolist(), kept["rest_px"][()].astype(float), strict=True)
                return SplitMarkers(
                    image=kept["image"][()].astype(int),
                    unit=kept["unit"][()].astype(int),
                    markers_px=kept["markers_px"][()].astype(float),
                    rest_px=dict(rest),
                )
        except (OSError, KeyError, ValueError) as error:
            raise PalpateError(
                f"{path} has no readable marker positions of {design}: {error}.",
                _AGAIN,
                code="benchmark-markers-damaged",
            ) from error

    def pictures(self, split: Split, names: Sequence[str], size: tuple[int, int]) -> NDArray[np.uint8]:
        """Return rendered images (n, h, w) of one split, resized to (h, w).

        Raises
        ------
        PalpateError
            If an image is missing or damaged.
        """
        cv2, path, found = load_opencv(), self.folder / f"{split}_pictures.zip", []
        try:
            with zipfile.ZipFile(path) as archive:
                for name in names:
                    grey = decode_image(archive.read(name), name)
                    found.append(cv2.resize(grey, size[::-1], interpolation=cv2.INTER_AREA))
        except (OSError, KeyError, zipfile.BadZipFile, cv2.error) as error:
            raise PalpateError(
                f"{path} cannot be read: {error}.", _AGAIN, code="benchmark-file-unreadable"
            ) from error
        return np.array(found, np.uint8).reshape(-1, *size)


def read_set(folder: Path) -> BenchmarkSet:
    """Open a data set.

    Raises
    ------
    PalpateError
        If the folder does not contain one.
    """
    try:
        digest(folder / CHECKSUMS)
        content = json.loads((folder / "spec.json").read_text(encoding="utf-8"))
        return BenchmarkSet(folder, BenchmarkSpec.model_validate(content))
    except (OSError, ValueError, ValidationError) as error:
        raise PalpateError(
            f"{folder} is not a benchmark data set: its spec.json or SHA256SUMS cannot be read.",
            _AGAIN,
            code="benchmark-missing",
        ) from error


def _read_columns(path: Path) -> dict[str, list[str]]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
    except (OSError, ValueError, csv.Error) as error:
        raise PalpateError(f"{path} cannot be read.", _AGAIN, code="benchmark-file-unreadable") from error
    if any(len(row) != len(head) for row in rows) or not rows:
        raise PalpateError(
            f"{path} has no rows, or rows of different lengths.", _AGAIN, code="benchmark-table-damaged"
        )
    return dict(zip(head, map(list, zip(*rows, strict=True)), strict=True))
