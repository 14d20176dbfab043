"""Readers of recordings, one a format; other packages register more."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar, final

from palpate.core import PalpateError, Registry
from palpate.datasets.recording_images import ImageSet
from palpate.datasets.table import RecordingTable, read_table


class RecordingReader(ABC):
    """Reader of one format of recordings.

    Attributes
    ----------
    formats
        Names of the formats in messages.
    has_topics
        Whether `pose` chooses a source of poses.
    image
        Which of several images a row has is read: a key or path, as ``--image`` gives it; empty if there is one.
    pose
        Which of several sources of poses is read, as ``--pose`` gives it; empty if there is one.
    """

    formats: ClassVar[str]
    has_topics: ClassVar[bool] = False
    image: str = ""
    pose: str = ""

    def choose(self, name: str, keys: Sequence[str]) -> str:
        """Return the one key of images that is meant by `image`: a whole key, or its last part.

        Raises
        ------
        PalpateError
            If none is, or several are.
        """
        ends = [key for key in keys if re.split(r"[./]", key)[-1] == self.image]
        found = [key for key in keys if key.strip("/") == self.image.strip("/")] or ends if self.image else list(keys)
        if len(found) == 1:
            return found[0]
        if not found:
            raise PalpateError(
                f"{name} has no images {self.image}; it has {', '.join(keys)}.",
                "Choose one of these by --image.",
                code="column-unknown",
            )
        raise PalpateError(
            f"{name} has images of {len(found)} cameras: {', '.join(found)}.",
            f"Choose the sensor's camera, such as --image {found[0]}.",
            code="recording-several-cameras",
        )

    @classmethod
    @abstractmethod
    def accepts(cls, place: Path) -> bool:
        """Return whether an existing file or folder is of this format, without reading it whole."""

    @abstractmethod
    def read(self, place: Path) -> tuple[RecordingTable, ImageSet | None]:
        """Return the table with one row per image, and the images, `None` if a column names their files.

        Raises
        ------
        PalpateError
            If it cannot be read.
        """


@contextmanager
def reading(name: str, remedy: str) -> Iterator[None]:
    """Replace errors of every kind, by which parsers end in a damaged file, by one that names the file."""
    try:
        yield
    except PalpateError:
        raise
    except Exception as error:
        raise PalpateError(f"{name} cannot be read: {error}.", remedy, code="recording-unreadable") from error


@final
class TableReader(RecordingReader):
    """Text tables, JSON lines and Parquet next to image files or a video."""

    formats = ".csv, .tsv, .txt, .dat, .json, .jsonl, .ndjson, .parquet"

    @classmethod
    def accepts(cls, place: Path) -> bool:
        return place.is_file() and place.suffix.lower() in cls.formats.split(", ")

    def read(self, place: Path) -> tuple[RecordingTable, ImageSet | None]:
        return read_table(place), None


READERS: Registry[type[RecordingReader]] = Registry(
    "palpate.recording_readers",
    "reader of recordings",
    {
        "lerobot": "palpate.datasets.read_lerobot:LeRobotReader",
        "table": "palpate.datasets.recording_reader:TableReader",
        "hdf5": "palpate.datasets.read_hdf5:HDF5Reader",
        "arrays": "palpate.datasets.read_arrays:ArraysReader",
        "rosbag": "palpate.datasets.read_rosbag:RosbagReader",
    },
    fits=lambda found: isinstance(found, type) and issubclass(found, RecordingReader),
)
"""Readers by name, in the order in which they are asked whether they accept a file or folder."""
