"""Recordings as NPZ files and Zarr stores: images as one array, poses as arrays of as many rows.

A Zarr store may keep its arrays in the group ``data`` and the ends of its episodes in ``meta/episode_ends``, as
diffusion policies do; each episode counts as a press. Zarr needs the extra ``zarr``.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from traceback import extract_tb
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError, load_extra
from palpate.datasets.recording_images import ImageSet, SeparateImages, file_stamp
from palpate.datasets.recording_reader import RecordingReader, reading
from palpate.datasets.stored_images import holds_images, join_parts, list_arrays, merge_columns, read_row
from palpate.datasets.table import RecordingTable

_REMEDY = "Give images as one array (n, h, w) or (n, h, w, 3), and poses as arrays of n rows."
_ENDS = "episode_ends"


@final
class ArraysReader(RecordingReader):
    """Images and poses as arrays of one NPZ file or Zarr store."""

    formats = ".npz, .zarr"

    @classmethod
    def accepts(cls, place: Path) -> bool:
        return place.suffix.lower() in cls.formats.split(", ")

    def read(self, place: Path) -> tuple[RecordingTable, ImageSet]:
        with reading(place.name, _REMEDY):
            return self._read(place, _read_npz(place) if place.suffix.lower() == ".npz" else _read_zarr(place))

    def _read(self, place: Path, arrays: Mapping[str, Any]) -> tuple[RecordingTable, ImageSet]:
        held = [name for name, array in arrays.items() if holds_images(array)]
        cameras = [name for name in held if arrays[name].dtype.kind != "b"] or held  # masks lie beside images
        if not cameras:
            raise PalpateError(
                f"{place.name} holds no images{list_arrays(arrays)}.", _REMEDY, code="recording-no-images"
            )
        images = arrays[self.choose(place.name, cameras)]
        columns = merge_columns(
            ([name], array, {})
            for name, array in arrays.items()
            if name not in held and array.ndim in (1, 2) and array.shape[0] == images.shape[0]
        )
        if _ENDS in arrays:
            press = np.searchsorted(np.asarray(arrays[_ENDS][:]), np.arange(images.shape[0]), side="right")
            columns.setdefault("press", press.astype(float))
        joined = join_parts(place.name, [columns], list_arrays(arrays))
        return RecordingTable(place.name, joined, {}), _Rows(place, images)


def _read_npz(place: Path) -> dict[str, Any]:
    with np.load(place, allow_pickle=False) as file:
        return {name: file[name] for name in file.files}


def _read_zarr(place: Path) -> dict[str, Any]:
    zarr = load_extra("zarr", "zarr", "Zarr")
    logging.getLogger("asyncio").addFilter(_is_not_of_zarr)
    root = zarr.open_group(str(place), mode="r")
    groups = [root, *(root[name] for name in ("data", "meta") if name in root)]
    return {name: array for group in groups for name, array in group.arrays()}


def _is_not_of_zarr(record: logging.LogRecord) -> bool:
    """Return whether a logged error is not one of Zarr, which logs those after the first."""
    error = record.exc_info[1] if record.exc_info else None
    return error is None or all("zarr" not in frame.filename for frame in extract_tb(error.__traceback__))


@final
class _Rows(SeparateImages):
    """Rows of an array of images."""

    def __init__(self, place: Path, images: Any) -> None:
        self._images, self._stamp = images, file_stamp(place)

    def stamp(self, number: int) -> str:
        return f"{self._stamp} {number}"

    def image(self, number: int) -> NDArray[Any]:
        return read_row(self._images, number)
