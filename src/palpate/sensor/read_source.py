"""Reading of an image source in its own thread; a lost camera is reported and reopened."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol

from numpy.typing import NDArray

from palpate.camera import Source
from palpate.core import PalpateError
from palpate.sensor.broadcast import Row
from palpate.sensor.reading import Reading
from palpate.sensor.write_readings import describe_reading

THERE, GONE = "there", "gone"
"""Values of `camera` in a row: images arrive; the source has ended or cannot be opened."""
_ENDED = "The source has ended."


class ReadsImages(Protocol):
    """A sensor or a wrapper of one."""

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Return the reading of the next image, or of an error in its place."""


class SourceReader:
    """Reader of images one by one, from any thread.

    Every reading is published as plain data, in the thread that read it; one image at a time is read.
    """

    def __init__(self, sensor: ReadsImages, publish: Callable[[Row], None]) -> None:
        self._sensor, self._publish = sensor, publish
        self._lock = threading.Lock()
        self._stop = threading.Event()

    def read(self, image: NDArray[Any] | PalpateError) -> Row:
        """Read one image, publish its reading and return it."""
        with self._lock:
            taken = time.time()
            row = _row(self._sensor.read(image), THERE, taken)
            try:
                self._publish(row)
            except Exception as error:  # this reading cannot be sent; a flagged one takes its place
                row = _row(self._sensor.read(PalpateError.of(error)), THERE, taken)
                self._publish(row)
        return row

    def run(self, open_again: Callable[[], Source], retry_s: float = 1.0, again: bool = True) -> None:
        """Read a source until `stop`; if it ends or cannot be opened, report this once and try again.

        Any error of a source counts as its end. An error that stops reading altogether is published as a last
        reading. A try follows the last one after `retry_s`; `again` is `False` for files.
        """
        try:
            self._follow(open_again, retry_s, again)
        except BaseException as error:
            with suppress(Exception):
                self._gone(PalpateError.of(error).problem)
            raise

    def _follow(self, open_again: Callable[[], Source], retry_s: float, again: bool) -> None:
        told = False
        while not self._stop.is_set():
            reason = _ENDED
            try:
                with open_again() as source:
                    for item in source.images():
                        if self._stop.is_set():
                            return
                        if isinstance(item, PalpateError):
                            reason = item.problem
                        else:
                            told, reason = False, _ENDED
                        self.read(item)
            except Exception as error:  # a camera's library may raise anything
                reason = PalpateError.of(error).problem
            if not told:
                self._gone(reason)
                told = True
            if not again or self._stop.wait(retry_s):
                return

    def stop(self) -> None:
        """End `run` after the current image."""
        self._stop.set()

    def _gone(self, reason: str) -> None:
        with self._lock:
            row = _row(
                self._sensor.read(PalpateError(reason, "Connect the camera.", code="source-gone")), GONE, time.time()
            )
            self._publish(row)


def _row(reading: Reading, camera: str, taken: float) -> Row:
    return describe_reading(reading) | {"camera": camera, "taken_s": taken}
