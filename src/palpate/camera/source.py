"""Where images come from: a camera, a video, a recording of an event camera or a folder, all behind one contract.

A source hands on images one by one and keeps none. What cannot be read comes as an error in the image's place; a
camera that gives nothing any more, or a file that is cut off, ends with one. Each kind of source stands in a file of
`palpate.camera.sources` or in another package, which names it in its entry points (group ``palpate.sources``);
`palpate.testing.SourceSuite` holds it to this contract.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar, Self

from numpy.typing import NDArray

from palpate.core import PalpateError, Registry

ImageOrError = NDArray[Any] | PalpateError


class Source(ABC):
    """Images one by one. It is closed when the block that opened it ends.

    What a person opens by a text takes that text, and nothing else, where it is made.

    Attributes
    ----------
    suffixes
        Endings of the files that it opens, in small letters with the dot.
    live
        Whether an image is handed on as it is taken; false of what was recorded.
    """

    suffixes: ClassVar[tuple[str, ...]] = ()
    live: ClassVar[bool] = False

    @classmethod
    def accepts(cls, text: str) -> bool:
        """Whether the text names such a source, there or not: by its ending, if there is no other way to tell."""
        return Path(text).suffix.lower() in cls.suffixes

    @property
    @abstractmethod
    def name(self) -> str:
        """What a person reads."""

    @property
    def truth(self) -> tuple[float, ...] | None:
        """Pose of the wall in the image handed on last: rx, ry (degrees), depth (mm); `None` where nobody knows."""
        return None

    @property
    def clock(self) -> Callable[[], float] | None:
        """Tells in s when the image handed on last was taken; `None` of what was recorded."""
        return time.monotonic if self.live else None

    @abstractmethod
    def images(self) -> Iterator[ImageOrError]:
        """The images, (h, w) or (h, w, 3) blue, green, red; an error in the place of one that cannot be read."""

    def close(self) -> None:
        """Give the camera or file back."""
        return

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


_HERE = "palpate.camera.sources"

SOURCES: Registry[type[Source]] = Registry(
    "palpate.sources",
    "source of images",
    {
        "camera": f"{_HERE}.numbered_camera:CameraSource",
        "video": f"{_HERE}.video:VideoSource",
        "event-recording": f"{_HERE}.event_recording:EventCameraSource",
        "folder": f"{_HERE}.folder:FolderSource",
    },
    fits=lambda found: isinstance(found, type) and issubclass(found, Source),
)
"""Sources by name, in the order in which they are asked whether they know a text."""


def open_source(text: str) -> Source:
    """Open a source.

    Parameters
    ----------
    text
        Number of a camera, or path of a folder of images, a video or an AEDAT4 recording, or what a source of another
        package accepts; with the name of a source and a colon before it, it is opened by that one.

    Raises
    ------
    PalpateError
        If there is no such camera or file, or it cannot be opened.
    MissingExtraError
        If OpenCV, or dv-processing for AEDAT4, is not installed.
    """
    name, colon, rest = text.partition(":")
    if colon and name in SOURCES:
        return _open(SOURCES.get(name), rest)
    kind = next((kind for _, kind in SOURCES.available() if kind.accepts(text)), None)
    if kind is None and Path(text).is_file():
        raise PalpateError(
            f"{Path(text).name} is no video that is known.",
            f"Known are {', '.join(recording_suffixes())}, folders and numbers.",
            code="video-format-unknown",
        )
    return _open(kind or SOURCES.get("folder"), text)


def recording_suffixes() -> tuple[str, ...]:
    """Endings of all files that `open_source` knows, in small letters with the dot."""
    return tuple(suffix for _, kind in SOURCES.available() for suffix in kind.suffixes)


def _open(kind: Any, text: str) -> Source:
    source: Source = kind(text)
    return source
