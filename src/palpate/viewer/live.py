"""Live sensor: images, markers and readings for the page."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Source
from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.design import TILT_SPACE
from palpate.learn import Predictor, RecordedModel
from palpate.sensor import Reading, Sensor, Unit, check_model, describe_reading, open_sensor, run_sensor
from palpate.surrogate import Twin
from palpate.viewer.results import GridDesign

LONGEST = 100_000
"""Maximum number of recorded readings."""


class LiveVerdict(StrEnum):
    """Whether the wall is perpendicular to within a tolerance."""

    GO = "go"
    NO_GO = "no go"
    UNSURE = "unsure"
    NO_TOUCH = "no touch"


@dataclass(frozen=True, eq=False)
class LiveImage:
    """Result of one image.

    Attributes
    ----------
    image
        (h, w) grey levels; `None` for an unreadable image.
    reading
        The pose.
    positions_px, found
        (m, 2) px and (m,) marker positions, and whether a blob was found at each.
    truth
        rx, ry (degrees) and depth (mm) if known.
    """

    image: NDArray[np.uint8] | None
    reading: Reading
    positions_px: FloatArray
    found: BoolArray
    truth: tuple[float, ...] | None


class Live:
    """Sensor that reads the images of a source until `close`.

    Parameters
    ----------
    sensor
        A unit of a design, or a model trained on a recording.
    source, images
        Source of images, and images already taken from it.
    size_px
        Height and width of the images.
    rest_px
        (m, 2) markers at rest, px.
    """

    def __init__(
        self,
        sensor: Sensor | RecordedModel,
        source: Source,
        images: Iterator[NDArray[Any] | PalpateError],
        size_px: tuple[int, int],
        rest_px: FloatArray,
    ) -> None:
        self.sensor, self.size_px, self.rest_px = sensor, size_px, rest_px
        self._source, self._images = source, images
        self._lock = threading.Lock()
        self._count = 0
        self.record: list[dict[str, Any]] | None = None

    def step(self) -> LiveImage | None:
        """Read the next image; `None` at the end of the source."""
        with self._lock:
            item, truth = self._next(), self._source.truth
        if item is None:
            return None
        reading = self._read(item)
        if self.record is not None and len(self.record) < LONGEST:
            self.record.append(describe_reading(reading))
        seen, image = reading.sighting, _shown(item)
        if seen is None:
            return LiveImage(image, reading, self.rest_px, np.zeros(len(self.rest_px), bool), truth)
        return LiveImage(image, reading, seen.positions_px, seen.found, truth)

    def _next(self) -> NDArray[Any] | PalpateError | None:
        """Return the next image; an exception of the camera's library is returned as an error."""
        try:
            return next(self._images, None)
        except PalpateError:
            raise
        except Exception as error:
            return PalpateError.of(error)

    def _read(self, item: NDArray[Any] | PalpateError) -> Reading:
        if isinstance(self.sensor, Sensor):
            return self.sensor.read(item)
        self._count += 1
        return replace(next(iter(run_sensor(self.sensor, [item]))), image=self._count)

    def close(self) -> None:
        """Release the camera or file."""
        with self._lock:
            self._source.close()


def open_live(design: GridDesign, model: Predictor | Twin, source: Source, *, marked: bool = True) -> Live:
    """Open a unit of a design on the first image of a source, which must be a rest image.

    Parameters
    ----------
    design, model
        The unit's design and its estimator.
    source
        Images.
    marked
        Whether the orientation mark is printed.

    Raises
    ------
    PalpateError
        If there is no image, or the blobs do not match the design.
    """
    images = source.images()
    first = _first_of(images, "Record the untouched dome first.")
    unit = Unit(design.design, has_orientation_mark=marked)
    check_model(model, unit, TILT_SPACE)
    sensor = open_sensor([first], unit, model)
    sensor.clock = source.clock
    return Live(sensor, source, images, first.shape[:2], sensor.assignment.positions_px)


def open_recorded_live(model: RecordedModel, source: Source) -> Live:
    """Open a sensor trained on a recording; it needs no rest image.

    Raises
    ------
    PalpateError
        If there is no image, or it has another size than those of the recording.
    """
    images = source.images()
    first = _first_of(images, "Give a folder of images, a video or a camera.")
    model.preprocessor.extract(first)
    rest = np.zeros((0, 2)) if model.layout is None else model.layout.rest_px
    return Live(model, source, chain([first], images), first.shape[:2], rest)


def _shown(item: NDArray[Any] | PalpateError) -> NDArray[np.uint8] | None:
    """Grey levels of an image; `None` for an error."""
    if isinstance(item, PalpateError):
        return None
    try:
        return to_grey(item)
    except (ValueError, TypeError, IndexError):
        return None


def _first_of(images: Iterator[NDArray[Any] | PalpateError], remedy: str) -> NDArray[Any]:
    first = next(images, None)
    if first is None:
        raise PalpateError("The source has no image.", remedy, code="source-no-image")
    if isinstance(first, PalpateError):
        raise first
    return first


def rate_reading(reading: Reading, tolerance_deg: float) -> LiveVerdict:
    """Compare the tilt of a reading, with its interval, with a tolerance in degrees.

    The interval of the tilt is the range of the tilt over the intervals |rx ± a| and |ry ± b| of its components.
    """
    if not reading.touching or math.isnan(reading.pose[0]):
        return LiveVerdict.NO_TOUCH
    least, most = tilt_interval(reading)
    if most <= tolerance_deg:
        return LiveVerdict.GO
    return LiveVerdict.NO_GO if least > tolerance_deg else LiveVerdict.UNSURE


def tilt_interval(reading: Reading) -> tuple[float, float]:
    """Minimum and maximum tilt (degrees) within the intervals of the two components."""
    pairs = [(abs(value), half) for value, half in zip(reading.pose[:2], reading.half_width, strict=False)]
    least = math.hypot(*(max(size - half, 0.0) for size, half in pairs))
    most = math.hypot(*(size + half for size, half in pairs))
    return least, most


def to_grey(image: NDArray[Any]) -> NDArray[np.uint8]:
    """An image of any depth and colour as grey levels (h, w) from 0 to 255."""
    grey = image if image.ndim == 2 else image[..., :3].mean(axis=-1)
    if image.dtype == np.uint16:
        grey = grey / 257.0
    return np.clip(grey, 0, 255).astype(np.uint8)
