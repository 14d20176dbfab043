"""HDF5 recordings: one array of images and arrays of poses, or one group of these per press.

One dataset of the file, or of each group, holds the images (`palpate.datasets.stored_images`). A folder of files
whose names differ by a number is read as a whole, each file a press.
Each further dataset of n or (n, k) numbers gives a column, or k columns, named by its attribute ``columns`` if it
exists. Each group, such as robomimic's ``data/demo_0``, counts as a press.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, final

import h5py
import numpy as np

from palpate.core import PalpateError, reject_external_links
from palpate.core.files import natural_key
from palpate.datasets.recording_images import ArrayImages, ImageSet
from palpate.datasets.recording_reader import RecordingReader, reading
from palpate.datasets.stored_images import holds_images, join_parts, list_arrays, merge_columns
from palpate.datasets.table import Column, RecordingTable

_REMEDY = "Give images as one dataset (n, h, w), (n, h, w, 3) or of n JPEG files, and poses as others of n rows."


@final
class HDF5Reader(RecordingReader):
    """Images and poses in one HDF5 file."""

    formats = ".h5, .hdf5"

    @classmethod
    def accepts(cls, place: Path) -> bool:
        if place.is_dir():
            return len(_episodes(place)) > 1
        return place.is_file() and place.suffix.lower() in cls.formats.split(", ")

    def read(self, place: Path) -> tuple[RecordingTable, ImageSet]:
        parts: list[dict[str, Column]] = []
        places: list[tuple[Path, str, int]] = []
        held = ""
        for path in _episodes(place) if place.is_dir() else [place]:
            with reading(path.name, _REMEDY), h5py.File(path, "r") as file:
                reject_external_links(file, path)
                held = held or list_arrays(_arrays(file))
                for images, group in self._groups(path, file):
                    parts.append(_columns(group, images, images.shape[0]))
                    places += [(path, images.name, row) for row in range(images.shape[0])]
        for number, part in enumerate(parts if len(parts) > 1 else ()):
            part.setdefault("press", np.full(len(next(iter(part.values()), ())), float(number)))
        return RecordingTable(place.name, join_parts(place.name, parts, held), {}), ArrayImages(places)

    def _groups(self, path: Path, file: h5py.File) -> list[tuple[h5py.Dataset, h5py.Group]]:
        """Datasets of images and the groups that hold their columns, in the order of their names."""
        held = [item for item in _arrays(file).values() if holds_images(item)]
        found = [item for item in held if item.dtype.kind != "b"] or held  # masks lie beside images
        owners: dict[str, tuple[h5py.Group, dict[str, h5py.Dataset]]] = {}
        for item in sorted(found, key=lambda one: natural_key(one.name)):
            owner = item.parent
            while owner.name != "/" and not any(_fits(one, item.shape[0]) for one in owner.values()):
                owner = owner.parent
            key = item.name[len(owner.name.rstrip("/")) :].strip("/")
            owners.setdefault(owner.name, (owner, {}))[1][key] = item
        if not owners:
            raise PalpateError(
                f"{path.name} holds no images{list_arrays(_arrays(file))}.", _REMEDY, code="recording-no-images"
            )
        return [(images[self.choose(path.name, list(images))], owner) for owner, images in owners.values()]


def _episodes(folder: Path) -> list[Path]:
    """HDF5 files of a folder, an episode each; none if their names differ by more than a number."""
    endings = HDF5Reader.formats.split(", ")
    files = [path for path in folder.iterdir() if path.suffix.lower() in endings]
    alike = len({re.sub(r"\d+", "", path.name) for path in files}) == 1
    return sorted(files, key=lambda path: natural_key(path.name)) if alike else []


def _arrays(group: h5py.Group) -> dict[str, h5py.Dataset]:
    """Arrays of a group and of those below it, by their paths."""
    found: dict[str, h5py.Dataset] = {}

    def look(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = item

    group.visititems(look)
    return found


def _fits(item: Any, count: int) -> bool:
    return (
        isinstance(item, h5py.Dataset)
        and item.ndim in (1, 2)
        and item.shape[0] == count
        and item.dtype.kind in "iufbV"
        and not holds_images(item)
    )


def _columns(group: h5py.Group, images: h5py.Dataset, count: int) -> dict[str, Column]:
    owners = {owner.name: owner for owner in (group, images.parent)}
    near = [pair for owner in owners.values() for pair in owner.items() if _fits(pair[1], count)]
    return merge_columns(
        (key.split("/"), item, item.attrs)
        for key, item in near or [pair for pair in _arrays(group).items() if _fits(pair[1], count)]
    )
