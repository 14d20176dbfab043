"""Recordings of event cameras."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from palpate.camera.source import ImageOrError, Source
from palpate.core import PalpateError, load_extra


@final
class EventCameraSource(Source):
    """Images (without events) of an AEDAT4 recording, as a DAVIS writes it."""

    suffixes: ClassVar[tuple[str, ...]] = (".aedat4",)

    def __init__(self, text: str) -> None:
        path = Path(text)
        if not path.is_file():
            raise PalpateError(f"{path} does not exist.", "Give a recording.", code="file-missing")
        dv = load_extra("dv_processing", "davis", "dv-processing")
        self._path = path
        try:
            self._recording = dv.io.MonoCameraRecording(str(path))
            has_images = self._recording.isFrameStreamAvailable()
        except (RuntimeError, ValueError, OSError) as error:
            raise PalpateError(
                f"{path.name} cannot be read: {_short(error)}.", "Record it again.", code="recording-unreadable"
            ) from error
        if not has_images:
            raise PalpateError(
                f"{path.name} contains events, but no images.",
                "Record the images of the camera as well.",
                code="recording-no-images",
            )

    @property
    def name(self) -> str:
        return str(self._path)

    def images(self) -> Iterator[ImageOrError]:
        while True:
            try:
                found = self._recording.getNextFrame()
            except (RuntimeError, ValueError, OSError) as error:
                yield PalpateError(
                    f"{self._path.name} is cut off or damaged: {_short(error)}.",
                    "Record it again.",
                    code="recording-damaged",
                )
                return
            if found is None:
                return
            yield np.asarray(found.image)


def _short(error: Exception) -> str:
    """Return the sentence of an error of dv-processing, without its stack."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[min(1, len(lines) - 1)].split(" - ")[0][:120] if lines else type(error).__name__
