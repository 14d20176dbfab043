"""Image sources: a camera, a video, a recording of an event camera or a folder, behind one interface.

A source yields images one by one and stores none. An unreadable image is replaced by an error. A lost camera, or a
file that is cut off, ends with an error. Each kind of source is in a file of `palpate.camera.sources`, or in another
package that names it in its entry points (group ``palpate.sources``). `palpate.testing.SourceSuite` tests a source
against this interface.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Self

from numpy.typing import NDArray

from palpate.core import PalpateError, Registry

ImageOrError = NDArray[Any] | PalpateError


class Source(ABC):
    """Images one by one; a context manager that closes the source.

    The constructor of a source that is opened by a text has this text as its only argument.

    Attributes
    ----------
    suffixes
        Endings of the files that it opens, in lower case, such as ``.mp4``.
    live
        Whether images are yielded when they are taken, rather than recorded.
    """

    suffixes: ClassVar[tuple[str, ...]] = ()
    live: ClassVar[bool] = False

    @classmethod
    def accepts(cls, text: str) -> bool:
        """Test whether a text names such a source, existing or not; by default, by its ending."""
        return Path(text).suffix.lower() in cls.suffixes

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the source for display."""

    @property
    def times(self) -> Sequence[float]:
        """Times, s, of the recorded images that are yielded so far; empty if they are unknown."""
        return ()

    @property
    def truth(self) -> tuple[float, ...] | None:
        """Pose of the wall in the last image: rx, ry (degrees), depth (mm); `None` if unknown."""
        return None

    @property
    def clock(self) -> Callable[[], float] | None:
        """Function that returns the time in s of the last image; `None` for recordings."""
        return time.monotonic if self.live else None

    @property
    def device(self) -> str:
        """File of a live camera, such as ``/dev/video0``; empty for other sources."""
        return ""

    @property
    def controls(self) -> Mapping[str, float]:
        """Controls of a live camera by their names in V4L2; empty if they are unknown."""
        return {}

    @abstractmethod
    def images(self) -> Iterator[ImageOrError]:
        """Yield images, (h, w) or (h, w, 3) blue, green, red; an error in place of one that cannot be read."""

    def close(self) -> None:
        """Release the camera or file."""
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
"""Sources by name, in the order in which they are asked to accept a text."""


def open_source(text: str) -> Source:
    """Open a source.

    Parameters
    ----------
    text
        Number of a camera or /dev/video0, path of a folder of images, a video or an AEDAT4 recording, or a text that
        a source of another package accepts. A source's name and a colon before the text select this source.

    Raises
    ------
    PalpateError
        If the camera or file does not exist, or cannot be opened.
    MissingExtraError
        If OpenCV, or dv-processing for AEDAT4, is not installed.
    """
    name, colon, rest = text.partition(":")
    if colon and name in SOURCES:
        return _open(SOURCES.get(name), rest)
    kind = next((kind for _, kind in SOURCES.available() if kind.accepts(text)), None)
    if kind is None and Path(text).is_file():
        raise PalpateError(
            f"{Path(text).name} is not a video of a supported format.",
            f"Give a file {', '.join(recording_suffixes())}, a folder, or the number of a camera.",
            code="video-format-unknown",
        )
    return _open(kind or SOURCES.get("folder"), text)


def recording_suffixes() -> tuple[str, ...]:
    """Return the endings of all files that `open_source` accepts, such as ``.mp4``."""
    return tuple(suffix for _, kind in SOURCES.available() for suffix in kind.suffixes)


def _open(kind: Any, text: str) -> Source:
    source: Source = kind(text)
    return source
