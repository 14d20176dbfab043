"""A thread that reads a source outlives whatever its camera, its images and its listeners do."""

import threading
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest

from made_up_readings import make_reading
from palpate.camera import Source
from palpate.core import PalpateError
from palpate.sensor import Flag, Reading
from palpate.sensor.read_source import GONE, THERE, SourceReader
from palpate.viewer.live import Live

IMAGE = np.zeros((4, 4), np.uint8)


class Counts:
    """A sensor that reads every image and flags every error."""

    def __init__(self) -> None:
        self.count = 0

    def read(self, image: Any) -> Reading:
        self.count += 1
        bad = isinstance(image, PalpateError)
        pose = np.full(3, np.nan if bad else 1.0)
        flags = (Flag.UNREADABLE,) if bad else ()
        return make_reading(pose, [np.inf] * 3, not bad, flags, image=self.count, found=0)


class Fails(Source):
    """Gives two images, then its library fails."""

    def __init__(self, error: BaseException) -> None:
        self._error = error

    @property
    def name(self) -> str:
        return "fails"

    def images(self) -> Iterator[Any]:
        yield IMAGE
        yield IMAGE
        raise self._error


@pytest.mark.parametrize("error", [cv2.error("no frame"), OSError("gone"), RuntimeError("driver")])
def test_whatever_a_cameras_library_raises_the_camera_is_opened_again(error: Exception) -> None:
    rows: list[dict[str, Any]] = []
    reader = SourceReader(Counts(), rows.append)

    def watch(row: dict[str, Any]) -> None:
        rows.append(row)
        if len(rows) >= 6:
            reader.stop()

    reader._publish = watch
    thread = threading.Thread(target=reader.run, args=(lambda: Fails(error), 0.01))
    thread.start()
    thread.join(10)
    assert not thread.is_alive()
    assert [row["camera"] for row in rows[:6]] == [THERE, THERE, GONE, THERE, THERE, GONE]
    assert rows[2]["flags"]


def test_a_thread_that_ends_leaves_a_flagged_reading() -> None:
    rows: list[dict[str, Any]] = []
    reader = SourceReader(Counts(), rows.append)
    with pytest.raises(KeyboardInterrupt):
        reader.run(lambda: Fails(KeyboardInterrupt()))
    assert rows[-1]["camera"] == GONE
    assert rows[-1]["flags"]


def test_a_reading_that_cannot_be_sent_is_replaced_by_a_flagged_one() -> None:
    rows: list[dict[str, Any]] = []

    def publish(row: dict[str, Any]) -> None:
        if not row["flags"]:
            raise np.linalg.LinAlgError("Singular matrix")
        rows.append(row)

    row = SourceReader(Counts(), publish).read(IMAGE)
    assert rows == [row]
    assert row["flags"]


def test_a_page_shows_a_flagged_reading_where_a_cameras_library_fails() -> None:
    source = Fails(cv2.error("no frame"))
    source.close = lambda: None
    live = Live(Counts(), source, source.images(), (4, 4), np.zeros((0, 2)))
    steps = [live.step() for _ in range(4)]
    assert [bool(step.reading.flags) for step in steps[:3]] == [False, False, True]
    assert steps[2].image is None
    assert steps[3] is None
