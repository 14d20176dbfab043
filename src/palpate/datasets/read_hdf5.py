"""Recordings in HDF5: images as one array and poses as others beside it, or such groups, a press each.

One dataset of the file, or of each group, has the shape (n, h, w) or (n, h, w, c) and whole numbers: the images.
Every other of n numbers, or of (n, k), is a column, or k of them, named by its attribute ``columns`` where it has
one. So the arrays of many labs, and robomimic's ``data/demo_0``, are read alike; each group counts as a press.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, final

import h5py
import numpy as np

from palpate.camera import natural_key
from palpate.core import PalpateError, reject_external_links
from palpate.datasets.recording_images import ArrayImages, ImageSet
from palpate.datasets.recording_reader import RecordingReader
from palpate.datasets.table import Column, RecordingTable

_REMEDY = "Give images as one dataset (n, h, w) of whole numbers, and poses as datasets of n rows beside it."


@final
class HDF5Reader(RecordingReader):
    """Images and poses in one HDF5 file."""

    formats = ".h5, .hdf5"

    @classmethod
    def accepts(cls, place: Path) -> bool:
        return place.is_file() and place.suffix.lower() in cls.formats.split(", ")

    def read(self, place: Path) -> tuple[RecordingTable, ImageSet]:
        try:
            with h5py.File(place, "r") as file:
                reject_external_links(file, place)
                groups = _groups(file)
                if not groups:
                    raise PalpateError(f"{place.name} holds no images.", _REMEDY, code="recording-no-images")
                parts, places = [], list[tuple[str, int]]()
                for number, (images, group) in enumerate(groups):
                    count = images.shape[0]
                    parts.append(_columns(group, images, count))
                    if len(groups) > 1:
                        parts[-1].setdefault("press", np.full(count, float(number)))
                    places += [(images.name, row) for row in range(count)]
        except (OSError, KeyError, ValueError) as error:
            raise PalpateError(
                f"{place.name} cannot be read: {error}.", _REMEDY, code="recording-unreadable"
            ) from error
        names = set.intersection(*(set(part) for part in parts))
        if not names - {"press"}:
            raise PalpateError(
                f"{place.name} has no numbers with as many rows as images.", _REMEDY, code="recording-no-table"
            )
        columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0] if name in names}
        return RecordingTable(place.name, columns, {}), ArrayImages(place, places)


def _groups(file: h5py.File) -> list[tuple[h5py.Dataset, h5py.Group]]:
    """Datasets of images and the groups that hold their columns, in the order of their names."""
    found: list[h5py.Dataset] = []

    def look(name: str, item: Any) -> None:
        if (
            isinstance(item, h5py.Dataset)
            and item.ndim in (3, 4)
            and item.dtype.kind == "u"
            and min(item.shape[1:3]) >= 8
        ):
            found.append(item)

    file.visititems(look)
    owners: dict[str, tuple[h5py.Dataset, h5py.Group]] = {}
    for item in sorted(found, key=lambda one: natural_key(one.name)):
        owner = item.parent
        while owner.name != "/" and not any(_fits(one, item.shape[0]) for one in owner.values()):
            owner = owner.parent
        owners.setdefault(owner.name, (item, owner))
    return list(owners.values())


def _fits(item: Any, count: int) -> bool:
    return (
        isinstance(item, h5py.Dataset) and item.ndim in (1, 2) and item.shape[0] == count and item.dtype.kind in "iuf"
    )


def _columns(group: h5py.Group, images: h5py.Dataset, count: int) -> dict[str, Column]:
    columns: dict[str, Column] = {}
    for owner in (group, images.parent):
        for key, item in owner.items():
            if not _fits(item, count):
                continue
            values = np.asarray(item[:], dtype=float).reshape(count, -1)
            given = item.attrs.get("columns", item.attrs.get("names", ()))
            names = [
                text.decode() if isinstance(text, bytes) else str(text) for text in np.atleast_1d(given).tolist()
            ]
            if len(names) == 1 and "," in names[0]:
                names = [text.strip() for text in names[0].split(",")]
            if len(names) != values.shape[1]:
                names = [key] if values.shape[1] == 1 else [f"{key}_{number}" for number in range(values.shape[1])]
            columns |= {name: values[:, number] for number, name in enumerate(names)}
    return columns
