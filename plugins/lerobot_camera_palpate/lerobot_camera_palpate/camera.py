"""Camera whose thread keeps the newest image, and the reading of it if a twin is configured."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from threading import Condition, Thread
from typing import Any

import numpy as np
from lerobot.cameras.camera import Camera
from lerobot.cameras.configs import ColorMode
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
from numpy.typing import NDArray

from lerobot_camera_palpate.config import PalpateCameraConfig
from palpate.camera import Source, open_source
from palpate.core import PalpateError
from palpate.sensor import Sensor, SensorLaunchSpec, describe_reading, open_from_parameters, parse_launch_spec

_LONGEST_S, _PATIENCE_S = 10.0, 2.0
"""Longest wait for an image, and for the thread to end: a camera that hangs is left to it."""
_ENDED = "the source has ended"


@dataclass(frozen=True)
class _Seen:
    """An image, when it came, and its reading."""

    picture: NDArray[np.uint8]
    at: float
    reading: dict[str, Any] | None


class PalpateCamera(Camera):
    """A tactile sensor's camera.

    Parameters
    ----------
    config
        Settings.
    """

    def __init__(self, config: PalpateCameraConfig) -> None:
        super().__init__(config)
        self.config = config
        self._news = Condition()
        self._newest: _Seen | None = None
        self._taken = True
        self._reason = ""
        self._thread: Thread | None = None
        self._going = False

    @property
    def is_connected(self) -> bool:
        """Whether images come."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def reading(self) -> dict[str, Any] | None:
        """Reading of the newest image by column of the tables of palpate; `None` without a twin."""
        with self._news:
            return None if self._newest is None else self._newest.reading

    @staticmethod
    def find_cameras() -> list[dict[str, Any]]:
        """Cameras that Linux knows, by the numbers that `source` takes."""
        numbers = sorted(int(path.name[5:]) for path in Path("/dev").glob("video*") if path.name[5:].isdigit())
        return [{"name": f"camera {number}", "type": "palpate", "id": str(number)} for number in numbers]

    def connect(self, warmup: bool = True) -> None:
        """Open the source, and with a twin read the untouched dome first; with `warmup`, wait for an image.

        Raises
        ------
        ConnectionError
            If the source cannot be opened, gives no image in time or another size, or the dome is not at rest.
        """
        if self.is_connected:
            raise DeviceAlreadyConnectedError(f"{self} is connected already.")
        try:
            sensor = self._open_sensor() if self.config.twin else None
            source = open_source(self.config.source)
        except PalpateError as error:
            raise ConnectionError(str(error)) from error
        self._newest, self._taken, self._reason, self._going = None, True, "", True
        self._thread = Thread(target=self._follow, args=(source, sensor), daemon=True)
        self._thread.start()
        if warmup or self.width is None or self.height is None:
            self._begin()

    def read(self) -> NDArray[Any]:
        """The next image, whenever it comes."""
        self._check_connected()
        with self._news:
            self._taken = True
        return self.async_read(_LONGEST_S * 1e3)

    def async_read(self, timeout_ms: float = 200) -> NDArray[Any]:
        """The newest image that was not handed out, waiting for it if need be."""
        self._check_connected()
        with self._news:
            self._news.wait_for(lambda: not self._taken or not self._going, timeout_ms / 1e3)
            if self._taken or self._newest is None:
                raise TimeoutError(f"{self} gave no image within {timeout_ms:g} ms. {self._reason}".strip())
            self._taken = True
            return self._newest.picture

    def read_latest(self, max_age_ms: int = 500) -> NDArray[Any]:
        """The newest image, handed out or not, unless it is older."""
        self._check_connected()
        with self._news:
            newest = self._newest
        if newest is None:
            raise RuntimeError(f"{self} has given no image yet. {self._reason}".strip())
        age_ms = (time.monotonic() - newest.at) * 1e3
        if age_ms > max_age_ms:
            raise TimeoutError(f"The newest image of {self} is {age_ms:.0f} ms old. {self._reason}".strip())
        return newest.picture

    def disconnect(self) -> None:
        """Give the source back."""
        if self._thread is None:
            raise DeviceNotConnectedError(f"{self} is not connected.")
        self._going = False
        self._thread.join(_PATIENCE_S)
        self._thread = None

    def __str__(self) -> str:
        return f"PalpateCamera({self.config.source})"

    def _open_sensor(self) -> Sensor:
        chosen = {
            name: getattr(self.config, name) for name in SensorLaunchSpec.model_fields if hasattr(self.config, name)
        }
        return open_from_parameters(parse_launch_spec(SensorLaunchSpec, chosen))

    def _begin(self) -> None:
        """Wait for the first image, and compare its size with the requested one."""
        with self._news:
            self._news.wait_for(lambda: not self._taken or not self._going, self.config.warmup_s)
            first, reason = self._newest, self._reason
        if first is None:
            self.disconnect()
            raise ConnectionError(f"{self} gave no image within {self.config.warmup_s:g} s. {reason}".strip())
        height, width = first.picture.shape[:2]
        if (self.width or width, self.height or height) != (width, height):
            asked = f"{self.width} x {self.height}"
            self.disconnect()
            raise ConnectionError(f"{self} gives {width} x {height} pixels, not {asked}. Leave width and height out.")
        self.width, self.height = width, height

    def _follow(self, source: Source, sensor: Sensor | None) -> None:
        """Keep the newest image until `disconnect`, or until the source ends."""
        with source:
            for item in source.images():
                if not self._going:
                    return
                reading = describe_reading(sensor.read(item)) if sensor else None
                with self._news:
                    if isinstance(item, PalpateError):
                        self._reason = item.problem
                    else:
                        self._newest, self._taken = _Seen(self._coloured(item), time.monotonic(), reading), False
                    self._news.notify_all()
        with self._news:
            self._going, self._reason = False, self._reason or _ENDED
            self._news.notify_all()

    def _coloured(self, image: NDArray[Any]) -> NDArray[np.uint8]:
        if image.ndim == 2:
            return np.repeat(image.astype(np.uint8)[..., None], 3, axis=2)
        return np.ascontiguousarray(image[..., ::-1] if self.config.color_mode == ColorMode.RGB else image, np.uint8)

    def _check_connected(self) -> None:
        if self._thread is None:
            raise DeviceNotConnectedError(f"{self} is not connected. Call connect() first.")
        if not self.is_connected and self._taken:
            raise DeviceNotConnectedError(f"{self} gives no more images: {self._reason}. Connect it again.")
