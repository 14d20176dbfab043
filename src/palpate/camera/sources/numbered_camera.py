"""Cameras of the system, by number."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import final

import numpy as np

from palpate.camera.source import ImageOrError, Source
from palpate.camera.sources.capture import open_capture
from palpate.core import PalpateError, load_opencv

_MISSES = 10
"""Number of missing images in a row after which a camera counts as disconnected. By hand."""
_DEVICE = "/dev/video"
_PATIENCE_S = 0.05
"""Waiting time after a missing image, s. By hand."""


@final
class CameraSource(Source):
    """A camera of the system by its number: UVC and others that OpenCV opens."""

    live = True

    def __init__(self, text: str) -> None:
        self._number = int(text.removeprefix(_DEVICE))
        self._capture = open_capture(self._number)

    @classmethod
    def accepts(cls, text: str) -> bool:
        return text.removeprefix(_DEVICE).isdecimal()

    @property
    def name(self) -> str:
        return f"camera {self._number}"

    @property
    def device(self) -> str:
        return f"{_DEVICE}{self._number}"

    @property
    def controls(self) -> dict[str, float]:
        """Controls that OpenCV reads; it returns -1 for others."""
        cv2 = load_opencv()
        if self._capture.getBackendName() != "V4L2":
            return {}
        known = {
            "auto_exposure": cv2.CAP_PROP_AUTO_EXPOSURE,
            "white_balance_automatic": cv2.CAP_PROP_AUTO_WB,
            "focus_automatic_continuous": cv2.CAP_PROP_AUTOFOCUS,
        }
        found = {name: float(self._capture.get(number)) for name, number in known.items()}
        return {name: value for name, value in found.items() if value >= 0.0}

    def images(self) -> Iterator[ImageOrError]:
        misses = 0
        while misses < _MISSES:
            read, image = self._capture.read()
            misses = 0 if read else misses + 1
            if read:
                yield np.asarray(image)
            else:
                time.sleep(_PATIENCE_S)
        yield PalpateError(f"Camera {self._number} sends no more images.", "Connect it again.", code="camera-gone")

    def close(self) -> None:
        self._capture.release()
