"""Recordings in NumPy's NPZ: an array of images and arrays of numbers beside it."""

from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from palpate.core import PalpateError
from palpate.datasets import ImageSet, RecordingReader, RecordingTable


class NpzReader(RecordingReader):
    formats = ".presses"

    @classmethod
    def accepts(cls, place: Path) -> bool:
        return place.is_file() and place.suffix == ".presses"

    def read(self, place: Path) -> tuple[RecordingTable, ImageSet]:
        try:
            with np.load(place) as file:
                arrays = dict(file)
            images = arrays.pop("images")
        except (OSError, KeyError, ValueError, BadZipFile) as error:
            raise PalpateError(
                f"{place.name} cannot be read: {error}.", "Give arrays of images and poses.", code="npz-unreadable"
            ) from error
        return RecordingTable(place.name, {name: values.astype(float) for name, values in arrays.items()}, {}), (
            NpzImages(place.name, images)
        )


class NpzImages(ImageSet):
    def __init__(self, name, images):
        self._name, self._images = name, images

    def stamp(self, number):
        return f"{self._name} {number}"

    def read(self, numbers):
        for number in numbers:
            yield self._images[number]
