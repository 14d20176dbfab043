"""Read a source in a thread of its own, through unplugging: a camera that is gone is said, and opened again."""

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
"""What `camera` of a row says: images come; the source has ended or cannot be opened."""
_ENDED = "The source has ended."


class ReadsImages(Protocol):
    """A sensor, or what stands before one."""

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Reading of the next image, or of what came in its place."""


class SourceReader:
    """Reads images one by one, whoever gives them.

    Parameters
    ----------
    sensor
        Opened already; one image at a time is read.
    publish
        Gets every reading as plain data, from the thread that read it.
    """

    def __init__(self, sensor: ReadsImages, publish: Callable[[Row], None]) -> None:
        self._sensor, self._publish = sensor, publish
        self._lock = threading.Lock()
        self._stop = threading.Event()

    def read(self, image: NDArray[Any] | PalpateError) -> Row:
        """Read one image, publish its reading and give it back."""
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
        """Read a source until `stop`; where it ends or cannot be opened, say so once, and try again.

        Any error of a source counts as its end. Where reading cannot go on at all, a last reading says so: nobody
        is left with an old one.

        Parameters
        ----------
        open_again
            Opens it.
        retry_s
            Time between two tries.
        again
            Whether it is tried again: cameras are, files are not.
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
        """End `run` after the image at hand."""
        self._stop.set()

    def _gone(self, reason: str) -> None:
        with self._lock:
            row = _row(self._sensor.read(PalpateError(reason, "Plug it in.", code="source-gone")), GONE, time.time())
            self._publish(row)


def _row(reading: Reading, camera: str, taken: float) -> Row:
    return describe_reading(reading) | {"camera": camera, "taken_s": taken}
