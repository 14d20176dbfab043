"""Files of the data set: HDF5 marker positions, CSV tables, archives of images, and checksums."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from palpate.calibration import UNIT_PARAMETERS, Deviation
from palpate.core import IntArray, PalpateError, load_opencv
from palpate.core.report import write_csv
from palpate.design import build_skin, place_markers
from palpate_benchmark.spec import BenchmarkDesign, BenchmarkSpec, Split
from palpate_benchmark.unit_images import LABELS, UnitImages

SET = "set"
"""Folder of the data set in a result folder."""
CHECKSUMS, HIDDEN, HIDDEN_UNITS = "SHA256SUMS", "hidden.csv", "hidden_units.csv"
SIGHT_COLUMNS = ("image", "design", "unit", "picture")
LABEL_COLUMNS = ("press", *LABELS, "branch")
MADE = ("modulus", *UNIT_PARAMETERS, "print_shift_x", "print_shift_y", "missing")
"""Fields of a unit's `Deviation` that affect its images or forces."""
_ROWS = 256
"""Images per chunk of the marker positions."""
_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True, eq=False)
class SplitPart:
    """One unit in the data set.

    Attributes
    ----------
    design, unit
        Design, and number of the unit, from 1.
    image
        (n,) numbers of its images.
    first_press
        Number of its first press.
    found
        Simulated images of the unit.
    """

    design: BenchmarkDesign
    unit: int
    image: IntArray
    first_press: int
    found: UnitImages

    def picture_names(self, split: str) -> list[str]:
        """Return the archive name of each image; empty if it is not rendered."""
        names = [""] * len(self.image)
        for row in self.found.pictured:
            names[row] = f"{split}/{self.image[row]:06d}.png"
        return names

    def rest_name(self, split: str) -> str:
        """Return the archive name of the rest image."""
        return f"{split}/rest_{self.design.name}_{self.unit:02d}.png"


def write_split(folder: Path, split: Split, parts: Sequence[SplitPart]) -> tuple[int, int]:
    """Write the files of one split; return the numbers of its images and of its rendered images."""
    rows: list[tuple[Any, ...]] = []
    for part in parts:
        found = part.found
        names = part.picture_names(split)
        branch = np.where(found.inverted, "inverted", "flat")
        for k, image in enumerate(part.image):
            sight = (int(image), part.design.name, part.unit, names[k])
            rows.append((*sight, part.first_press + int(found.press[k]), *found.labels[k].tolist(), str(branch[k])))
    rows.sort()
    count = len(SIGHT_COLUMNS)
    if split == "test":
        write_csv(folder / "test.csv", (row[:count] for row in rows), SIGHT_COLUMNS)
        write_csv(folder / HIDDEN, ((row[0], *row[count:]) for row in rows), ("image", *LABEL_COLUMNS))
    else:
        write_csv(folder / f"{split}.csv", rows, (*SIGHT_COLUMNS, *LABEL_COLUMNS))
    _write_markers(folder / f"{split}.h5", parts)
    pictures = _write_pictures(folder / f"{split}_pictures.zip", split, parts)
    return len(rows), pictures


def write_designs(folder: Path, spec: BenchmarkSpec) -> None:
    """Write the designs and their marker layouts."""
    head = ("design", "height_mm", "thickness_mm", "base_radius_mm", "markers", "dot_diameter_mm")
    designs, dots = [], []
    for design in spec.designs:
        skin = build_skin(design.skin)
        layout = place_markers(skin, design.marker_layout)
        size = (design.height, design.thickness, design.skin.base_radius)
        designs.append((design.name, *size, len(layout), round(float(layout.diameter), 6)))
        places = np.round(layout.positions, 6).tolist()
        dots += [(design.name, number, *place) for number, place in enumerate(places)]
    write_csv(folder / "designs.csv", designs, head)
    write_csv(folder / "layouts.csv", dots, ("design", "marker", "x_mm", "y_mm", "z_mm"))


def write_units(folder: Path, split: Split, built: Iterable[tuple[str, Deviation]]) -> None:
    """Write the deviations of the units of one split; those of the test go to a hidden file."""
    name = HIDDEN_UNITS if split == "test" else f"{split}_units.csv"
    rows = []
    for design, deviation in built:
        values = asdict(deviation)
        rows.append((design, deviation.unit, *(round(values[key], 9) for key in MADE)))
    write_csv(folder / name, rows, ("design", "unit", *MADE))


def list_files(folder: Path) -> tuple[int, str]:
    """Write the checksum of every file; return the total size in bytes and the checksum of the list."""
    lines, size = [], 0
    for path in sorted(folder.iterdir()):
        if path.name != CHECKSUMS:
            lines.append(f"{digest(path)}  {path.name}\n")
            size += path.stat().st_size
    text = "".join(lines).encode()
    (folder / CHECKSUMS).write_bytes(text)
    return size + len(text), hashlib.sha256(text).hexdigest()


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _write_markers(path: Path, parts: Sequence[SplitPart]) -> None:
    """Write marker positions by design: images by ascending number, rest images by unit."""
    with h5py.File(path, "w", libver="v110", track_order=False) as file:
        for name, group in groupby(parts, key=lambda part: part.design.name):
            own = list(group)
            image = np.concatenate([part.image for part in own])
            order = np.argsort(image)
            seen = np.concatenate([part.found.markers_px for part in own])[order]
            unit = np.repeat([part.unit for part in own], [len(part.image) for part in own])[order]
            rest = np.stack([part.found.rest_px for part in own])
            _put(file, f"{name}/image", image[order].astype(np.int32))
            _put(file, f"{name}/unit", unit.astype(np.int32))
            _put(file, f"{name}/markers_px", seen, (min(_ROWS, len(seen)), *seen.shape[1:]))
            _put(file, f"{name}/rest_unit", np.array([part.unit for part in own], np.int32))
            _put(file, f"{name}/rest_px", rest)


def _put(file: h5py.File, name: str, values: NDArray[Any], chunks: tuple[int, ...] | None = None) -> None:
    file.create_dataset(name, data=values, chunks=chunks, track_times=False)


def _write_pictures(path: Path, split: str, parts: Sequence[SplitPart]) -> int:
    """Write rendered images to an uncompressed archive; return their number without rest images."""
    named = []
    for part in parts:
        if len(part.found.pictures):
            names = part.picture_names(split)
            ordered = [part.rest_name(split), *(names[row] for row in part.found.pictured)]
            named += list(zip(ordered, part.found.pictures, strict=True))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, picture in sorted(named, key=lambda item: item[0]):
            archive.writestr(zipfile.ZipInfo(name, _DATE), _encode(picture))
    return sum(len(part.found.pictured) for part in parts if len(part.found.pictures))


def _encode(picture: NDArray[np.uint8]) -> bytes:
    done, encoded = load_opencv().imencode(".png", picture)
    if not done:
        raise PalpateError(
            "A rendered image could not be encoded as PNG.", "Reinstall the extra [vision].", code="image-not-encoded"
        )
    return bytes(encoded.tobytes())
