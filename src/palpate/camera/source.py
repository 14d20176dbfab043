"""Where images come from: a camera, a video, a recording of an event camera or a folder, all behind one contract.

A source hands on images one by one and keeps none. What cannot be read comes as an error in the image's place; a
camera that gives nothing any more, or a file that is cut off, ends with one.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from palpate.camera.opencv import load
from palpate.camera.read_image import LARGEST_MPX, list_images, read_image
from palpate.core import PalpateError, load_extra

Item = NDArray[Any] | PalpateError
VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".ogv")
EVENTS = ".aedat4"
_MISSES = 10
"""Images in a row that a camera may fail to give before it counts as unplugged."""
_PATIENCE_S = 0.05


class Source(ABC):
    """Images one by one. It is closed when the block that opened it ends."""

    @property
    @abstractmethod
    def name(self) -> str:
        """What a person reads."""

    @abstractmethod
    def images(self) -> Iterator[Item]:
        """The images, (h, w) or (h, w, 3) blue, green, red; an error in the place of one that cannot be read."""

    def close(self) -> None:
        """Give the camera or file back."""
        return

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class FolderSource(Source):
    """Image files by name; files that come later are not looked for."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._paths = list_images(folder)

    @property
    def name(self) -> str:
        return str(self._folder)

    def images(self) -> Iterator[Item]:
        for path in self._paths:
            try:
                yield read_image(path)
            except PalpateError as error:
                yield error


class VideoSource(Source):
    """A video file."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise PalpateError(f"{path} is not there.", "Give a video, a folder or the number of a camera.")
        self._path = path
        self._capture = open_capture(str(path))

    @property
    def name(self) -> str:
        return str(self._path)

    def images(self) -> Iterator[Item]:
        cv2 = load()
        promised, given = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT)), 0
        while True:
            read, image = self._capture.read()
            if not read:
                break
            given += 1
            yield np.asarray(image)
        if given < promised or not given:
            yield PalpateError(
                f"{self._path.name} ends after {given} of {max(promised, 0)} images: it is cut off or damaged.",
                "Record it again.",
            )

    def close(self) -> None:
        self._capture.release()


class CameraSource(Source):
    """A camera that the system knows by a number: UVC and others that OpenCV opens."""

    def __init__(self, number: int) -> None:
        self._number = number
        self._capture = open_capture(number)

    @property
    def name(self) -> str:
        return f"camera {self._number}"

    def images(self) -> Iterator[Item]:
        misses = 0
        while misses < _MISSES:
            read, image = self._capture.read()
            misses = 0 if read else misses + 1
            if read:
                yield np.asarray(image)
            else:
                time.sleep(_PATIENCE_S)
        yield PalpateError(f"Camera {self._number} gives no images any more.", "Is it unplugged?")

    def close(self) -> None:
        self._capture.release()


class EventCameraSource(Source):
    """The images (not the events) of an AEDAT4 recording, as of a DAVIS."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise PalpateError(f"{path} is not there.", "Give a recording.")
        dv = load_extra("dv_processing", "davis", "dv-processing")
        self._path = path
        try:
            self._recording = dv.io.MonoCameraRecording(str(path))
            has_images = self._recording.isFrameStreamAvailable()
        except (RuntimeError, ValueError, OSError) as error:
            raise PalpateError(f"{path.name} cannot be read: {_short(error)}.", "Record it again.") from error
        if not has_images:
            raise PalpateError(
                f"{path.name} holds events, but no images.", "Record the images of the camera as well."
            )

    @property
    def name(self) -> str:
        return str(self._path)

    def images(self) -> Iterator[Item]:
        while True:
            try:
                found = self._recording.getNextFrame()
            except (RuntimeError, ValueError, OSError) as error:
                yield PalpateError(f"{self._path.name} is cut off or damaged: {_short(error)}.", "Record it again.")
                return
            if found is None:
                return
            yield np.asarray(found.image)


def open_source(text: str) -> Source:
    """Open a source.

    Parameters
    ----------
    text
        Number of a camera, or path of a folder of images, a video or an AEDAT4 recording.

    Raises
    ------
    PalpateError
        If there is no such camera or file, or it cannot be opened.
    MissingExtraError
        If OpenCV, or dv-processing for AEDAT4, is not installed.
    """
    if text.isdecimal():
        return CameraSource(int(text))
    path = Path(text)
    if path.suffix.lower() in VIDEOS:
        return VideoSource(path)
    if path.suffix.lower() == EVENTS:
        return EventCameraSource(path)
    if path.is_file():
        raise PalpateError(
            f"{path.name} is no video that is known.",
            f"Known are {', '.join((*VIDEOS, EVENTS))}, folders and numbers.",
        )
    return FolderSource(path)


def open_capture(what: str | int) -> Any:
    """Open a video or camera by OpenCV, with its size checked before an image is decoded.

    Raises
    ------
    PalpateError
        If it cannot be opened, or its images are too large.
    """
    cv2 = load()
    capture = cv2.VideoCapture(what)
    if not capture.isOpened():
        known = f"camera {what}" if isinstance(what, int) else what
        raise PalpateError(
            f"{known} cannot be opened.",
            "Is it plugged in, and free? `--source synthetic` plays a simulated sensor."
            if isinstance(what, int)
            else "The file is damaged, or of a kind that this OpenCV does not read.",
        )
    width, height = capture.get(cv2.CAP_PROP_FRAME_WIDTH), capture.get(cv2.CAP_PROP_FRAME_HEIGHT)
    if width * height > LARGEST_MPX * 1e6:
        capture.release()
        raise PalpateError(
            f"{what} has {width:.0f} × {height:.0f} px, more than {LARGEST_MPX:g} million.", "Shrink it."
        )
    return capture


def _short(error: Exception) -> str:
    """The sentence of an error of dv-processing, without its stack."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[min(1, len(lines) - 1)].split(" - ")[0][:120] if lines else type(error).__name__
