"""Images of a recording: files, videos, arrays, or cells of a Parquet table.

They are read in ascending order, one by one.
"""

from __future__ import annotations

import os
import re
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, final

import h5py
from numpy.typing import NDArray

from palpate.camera import IMAGE_SUFFIXES, open_source, read_image
from palpate.core import PalpateError
from palpate.core.files import natural_key
from palpate.datasets.stored_images import read_row
from palpate.datasets.table import REST

Item = NDArray[Any] | PalpateError


def file_stamp(path: Path) -> str:
    """Return a text that changes with a file: its name, size and time."""
    try:
        about = path.stat()
    except OSError:
        return f"{path.name} does not exist"
    return f"{path.name} {about.st_size} {about.st_mtime_ns}"


class ImageSet(ABC):
    """Images by number."""

    @abstractmethod
    def stamp(self, number: int) -> str:
        """Return a text that changes with the image: name, size and time of its file."""

    @abstractmethod
    def read(self, numbers: Sequence[int]) -> Iterator[Item]:
        """Yield images by ascending numbers, with an error in place of an unreadable one."""


class SeparateImages(ImageSet):
    """Images that are read one by one."""

    @abstractmethod
    def image(self, number: int) -> NDArray[Any]:
        """Read an image (h, w) or (h, w, 3), BGR; any error is that of this image."""

    def read(self, numbers: Sequence[int]) -> Iterator[Item]:
        for number in numbers:
            try:
                yield self.image(number)
            except PalpateError as error:
                yield error
            except Exception as error:  # each codec has errors of its own
                yield PalpateError(
                    f"Image {number} cannot be read: {error}.", "Repair or leave it out.", code="image-unreadable"
                )


@final
class ImageFiles(SeparateImages):
    """Files of a folder."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self._paths = tuple(paths)

    def stamp(self, number: int) -> str:
        return file_stamp(self._paths[number])

    def image(self, number: int) -> NDArray[Any]:
        return read_image(self._paths[number])


@final
class VideoImages(ImageSet):
    """Images of one or more videos, each by its number in its video."""

    def __init__(self, videos: Sequence[Path], which: Sequence[int], frames: Sequence[int]) -> None:
        self._videos, self._which, self._frames = tuple(videos), tuple(which), tuple(frames)

    def stamp(self, number: int) -> str:
        return f"{file_stamp(self._videos[self._which[number]])} {self._frames[number]}"

    def read(self, numbers: Sequence[int]) -> Iterator[Item]:
        playing, at = -1, -1
        images: Iterator[Item] = iter(())
        item: Item = PalpateError("The video is empty.", code="video-empty")
        for number in numbers:
            video, frame = self._which[number], self._frames[number]
            if video != playing or frame < at:
                images, playing, at = open_source(str(self._videos[video])).images(), video, -1
            while at < frame:
                item = next(
                    images,
                    PalpateError(f"{self._videos[video].name} ends before its image {frame}.", code="video-cut-off"),
                )
                at += 1
            yield item


@final
class ArrayImages(SeparateImages):
    """Images of datasets of HDF5 files: file, dataset and row of each."""

    def __init__(self, places: Sequence[tuple[Path, str, int]]) -> None:
        self._places = tuple(places)

    def stamp(self, number: int) -> str:
        path, *place = self._places[number]
        return f"{file_stamp(path)} {(*place,)}"

    def read(self, numbers: Sequence[int]) -> Iterator[Item]:
        for path, group in groupby(numbers, lambda number: self._places[number][0]):
            with h5py.File(path, "r") as self._file:
                yield from super().read(list(group))

    def image(self, number: int) -> NDArray[Any]:
        _, name, row = self._places[number]
        return read_row(self._file[name], row)


@final
class SelectedImages(ImageSet):
    """Some images of a set, in ascending order."""

    def __init__(self, images: ImageSet, rows: Sequence[int]) -> None:
        self._images, self._rows = images, [int(row) for row in rows]

    def stamp(self, number: int) -> str:
        return self._images.stamp(self._rows[number])

    def read(self, numbers: Sequence[int]) -> Iterator[Item]:
        return self._images.read([self._rows[number] for number in numbers])


@final
class ConcatenatedImages(ImageSet):
    """The first `count` images of a set, and those of another after them."""

    def __init__(self, images: ImageSet, count: int, last: ImageSet) -> None:
        self._images, self._count, self._last = images, count, last

    def stamp(self, number: int) -> str:
        inside = number < self._count
        return self._images.stamp(number) if inside else self._last.stamp(number - self._count)

    def read(self, numbers: Sequence[int]) -> Iterator[Item]:
        yield from self._images.read([number for number in numbers if number < self._count])
        yield from self._last.read([number - self._count for number in numbers if number >= self._count])


def find_files(folder: Path, names: Sequence[str]) -> list[Path]:
    """Return the paths of images that a table names, next to it or below it if the name is unique.

    Raises
    ------
    PalpateError
        If none of them exists.
    """
    direct = [folder / name.replace("\\", "/") for name in names]
    if all(path.is_file() for path in direct):
        return direct
    files = list_below(folder)
    for key in (_whole_name, _bare_name):  # converted copies differ in their ending only
        below: dict[str, list[Path]] = {}
        for path in files:
            below.setdefault(key(path), []).append(path)
        twice = next(
            (below[key(path)] for path in direct if not path.is_file() and len(below.get(key(path), ())) > 1), None
        )
        if twice:
            folders = [str(path.parent.relative_to(folder)) for path in twice]
            raise PalpateError(
                f"{twice[0].name} is in {len(folders)} folders: {', '.join(folders)}.",
                f"Choose one by --image, such as --image {folders[-1]}.",
                code="images-in-several-folders",
            )
        found = [path if path.is_file() else below.get(key(path), [path])[0] for path in direct]
        if any(path.is_file() for path in found if path.stem.lower() != REST or len(found) == 1):
            return found
    raise PalpateError(
        f"None of the {len(names)} images of the table exists; the first is {names[0]}.",
        f"Put them next to the table, into {folder} or a folder in it.",
        code="images-missing",
    )


def find_numbered_files(folder: Path, numbers: Sequence[int]) -> list[Path] | None:
    """Image files by the last number in their names; `None` if one is missing or in several names."""
    below: dict[int, list[Path]] = {}
    for path in list_below(folder):
        if digits := re.findall(r"\d+", path.stem):
            below.setdefault(int(digits[-1]), []).append(path)
    if any(len(below.get(number, ())) != 1 for number in numbers):
        return None
    return [below[number][0] for number in numbers]


def _whole_name(path: Path) -> str:
    return path.name


def _bare_name(path: Path) -> str:
    return (path.stem if _is_image(path) else path.name).casefold()


def _is_image(path: Path) -> bool:
    return path.suffix.lower() in IMAGE_SUFFIXES and path.name[0] != "."


def list_below(folder: Path) -> list[Path]:
    """Image files of a folder and of all below it, by name; a linked folder is entered once."""
    found, entered = [], set[str]()
    for place, inner, files in os.walk(folder, followlinks=True):
        real = os.path.realpath(place)
        if real in entered:
            inner.clear()
            continue
        entered.add(real)
        found += [path for name in files if _is_image(path := Path(place) / name)]
    return sorted(found, key=lambda path: natural_key(str(path)))
