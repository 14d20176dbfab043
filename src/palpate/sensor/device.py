"""Sensor as a device: connect, poll for images, disconnect, like the interface of the DIGIT sensor.

    with Device(open_source("0")) as device:
        image = device.get_image()

A simulated sensor (`palpate.simulation.SimulatedSource`) works in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

from numpy.typing import NDArray

from palpate.camera import Source
from palpate.core import PalpateError


class Device:
    """One sensor (camera, recording or simulation), polled for its images."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._images: Iterator[NDArray[Any] | PalpateError] | None = None

    @property
    def name(self) -> str:
        """Name of the source, for display."""
        return self._source.name

    def connect(self) -> None:
        """Begin to take images; no effect if connected already."""
        if self._images is None:
            self._images = self._source.images()

    def get_image(self) -> NDArray[Any]:
        """Return the next image, (h, w) or (h, w, 3).

        Raises
        ------
        PalpateError
            If the device is not connected, has no more images, or this one cannot be read.
        """
        if self._images is None:
            raise PalpateError(f"{self.name} is not connected.", "Call connect first.", code="sensor-not-connected")
        image = next(self._images, None)
        if image is None:
            raise PalpateError(f"{self.name} has no more images.", "Connect it again.", code="source-ended")
        if isinstance(image, PalpateError):
            raise image
        return image

    def disconnect(self) -> None:
        """Close the camera or file."""
        self._images = None
        self._source.close()

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *_: object) -> None:
        self.disconnect()
