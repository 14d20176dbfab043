"""Videos that OpenCV reads."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from palpate.camera.source import ImageOrError, Source
from palpate.camera.sources.capture import open_capture
from palpate.core import PalpateError, load_opencv


@final
class VideoSource(Source):
    """A video file."""

    suffixes: ClassVar[tuple[str, ...]] = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".ogv")

    def __init__(self, text: str) -> None:
        path = Path(text)
        if not path.is_file():
            raise PalpateError(
                f"{path} is not there.", "Give a video, a folder or the number of a camera.", code="file-missing"
            )
        self._path = path
        self._capture = open_capture(text)

    @property
    def name(self) -> str:
        return str(self._path)

    def images(self) -> Iterator[ImageOrError]:
        cv2 = load_opencv()
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
                code="video-cut-off",
            )

    def close(self) -> None:
        self._capture.release()
