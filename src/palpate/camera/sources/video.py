"""Videos that OpenCV reads."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from palpate.camera.source import ImageOrError, Source
from palpate.camera.sources.capture import open_capture
from palpate.core import MissingExtraError, PalpateError, load_extra, load_opencv


@final
class VideoSource(Source):
    """A video file."""

    suffixes: ClassVar[tuple[str, ...]] = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".ogv")

    def __init__(self, text: str) -> None:
        path = Path(text)
        if not path.is_file():
            raise PalpateError(
                f"{path} does not exist.", "Give a video, a folder or the number of a camera.", code="file-missing"
            )
        self._path, self._times = path, list[float]()
        self._capture = open_capture(text)

    @property
    def name(self) -> str:
        return str(self._path)

    @property
    def times(self) -> list[float]:
        return self._times

    def images(self) -> Iterator[ImageOrError]:
        cv2 = load_opencv()
        promised, given, last_s, gap_s = int(self._capture.get(cv2.CAP_PROP_FRAME_COUNT)), 0, 0.0, 0.0
        fps = max(float(self._capture.get(cv2.CAP_PROP_FPS)), 1e-3)
        codec = int(self._capture.get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").lower()
        if codec == b"av01":
            yield from self._decode_av1()
            return
        while True:
            read, image = self._capture.read()
            if not read:
                break
            given += 1
            now_s = float(self._capture.get(cv2.CAP_PROP_POS_MSEC)) / 1e3
            last_s, gap_s = now_s, max(gap_s, now_s - last_s)
            self._times.append(now_s)
            yield np.asarray(image)
        if not given or (given < promised and not self._is_whole(given, promised, fps, last_s + 1.5 * gap_s)):
            yield PalpateError(
                f"{self._path.name} ends after {given} of {max(promised, 0)} images: it is cut off or damaged.",
                "Record it again.",
                code="video-cut-off",
            )

    def _is_whole(self, given: int, promised: int, fps: float, end_s: float) -> bool:
        """Test whether a video of fewer images than its header states is complete.

        An edit list may show a part of the images; in a container that stores no count, it is the duration times the
        mean rate. The end of the images is the last stamp and one and a half times their longest interval.
        """
        if self._path.suffix.lower() not in (".mp4", ".mov", ".m4v"):
            return self._path.suffix.lower() in (".mkv", ".webm") and end_s >= (promised - 1) / fps
        return given + 1 >= int(_duration_s(self._path) * fps) > 0

    def _decode_av1(self) -> Iterator[ImageOrError]:
        """Yield the images of an AV1 video by PyAV, since the wheels of OpenCV do not decode it."""
        try:
            av = load_extra("av", "av", "PyAV")
        except MissingExtraError:
            yield PalpateError(
                f"{self._path.name} is an AV1 video, which OpenCV does not decode.",
                f"pip install av, or convert it: ffmpeg -i {self._path.name} -c:v libx264 -crf 12 h264.mp4",
                code="video-av1",
            )
            return
        try:
            with av.open(str(self._path)) as container:
                for frame in container.decode(video=0):
                    self._times.append(frame.time or 0.0)
                    yield np.asarray(frame.to_ndarray(format="bgr24"))
        except (av.FFmpegError, OSError, IndexError, ValueError) as error:
            yield PalpateError(
                f"{self._path.name} is cut off or damaged: {error}.", "Record it again.", code="video-cut-off"
            )

    def close(self) -> None:
        self._capture.release()


def _duration_s(path: Path) -> float:
    """Return the duration, s, of an MP4 file with its edit list; 0 if the file is cut off."""
    content = path.read_bytes()
    at = 0
    while at + 8 <= len(content):
        size = int.from_bytes(content[at : at + 4], "big")
        size = int.from_bytes(content[at + 8 : at + 16], "big") if size == 1 else size or len(content) - at
        at += max(size, 8)
    head = content.find(b"mvhd")
    if at != len(content) or not 0 <= head < len(content) - 36:
        return 0.0
    long = content[head + 4] == 1
    scale, ticks = struct.unpack_from(">IQ" if long else ">II", content, head + (24 if long else 16))
    return float(ticks / max(scale, 1))
