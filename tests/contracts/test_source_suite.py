"""Every source of images of the package, one row each."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from needs import needs
from palpate.camera import SOURCES
from palpate.testing import SourceSuite


def grey(level: int) -> np.ndarray:
    return np.full((48, 64), level, np.uint8)


def make_folder(folder: Path, patch: pytest.MonkeyPatch) -> str:
    for number in range(3):
        cv2.imwrite(str(folder / f"{number}.png"), grey(50 * number))
    return str(folder)


def make_video(folder: Path, patch: pytest.MonkeyPatch) -> str:
    writer = cv2.VideoWriter(str(folder / "v.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 10, (64, 48))
    for number in range(3):
        writer.write(cv2.cvtColor(grey(50 * number), cv2.COLOR_GRAY2BGR))
    writer.release()
    return str(folder / "v.avi")


def make_recording(folder: Path, patch: pytest.MonkeyPatch) -> str:
    dv = needs("dv_processing")
    path = folder / "r.aedat4"
    writer = dv.io.MonoCameraWriter(str(path), dv.io.MonoCameraWriter.FrameOnlyConfig("DAVIS346", (64, 48)))
    for number in range(3):
        writer.writeFrame(dv.Frame(1_000_000 + 100_000 * number, grey(40 * number)))
    del writer
    return str(path)


class ThreeImages:
    """A camera as OpenCV gives it, pulled out after three images; that of any other number is not there."""

    def __init__(self, number: int) -> None:
        self.number, self.left = number, [grey(1), grey(2), grey(3)]

    def isOpened(self) -> bool:  # noqa: N802  (OpenCV's name)
        return self.number == 0

    def read(self) -> tuple[bool, np.ndarray | None]:
        return bool(self.left), self.left.pop(0) if self.left else None

    def get(self, _: int) -> float:
        return 64.0

    def release(self) -> None:
        pass


def make_camera(folder: Path, patch: pytest.MonkeyPatch) -> str:
    patch.setattr(cv2, "VideoCapture", ThreeImages)
    return "0"


ROWS = {
    "camera": (make_camera, "987"),
    "video": (make_video, "none.avi"),
    "event-recording": (make_recording, "none.aedat4"),
    "folder": (make_folder, "none"),
}


def test_every_source_has_a_row() -> None:
    assert set(ROWS) == set(SOURCES.names)


@pytest.mark.parametrize("row", ROWS)
class TestSource(SourceSuite):
    @pytest.fixture
    def text(self, row: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
        return ROWS[row][0](tmp_path, monkeypatch)

    @pytest.fixture
    def missing(self, row: str, tmp_path: Path) -> str:
        missing = ROWS[row][1]
        return missing if missing.isdecimal() else str(tmp_path / missing)
