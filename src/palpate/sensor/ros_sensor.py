"""Sensor as a ROS node: parameters in, messages by topic out; the node itself is in `ros/palpate_ros`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import open_source
from palpate.core import PalpateError, parameter
from palpate.sensor.broadcast import Row
from palpate.sensor.open_from_parameters import SensorLaunchSpec, open_from_parameters
from palpate.sensor.read_source import GONE, SourceReader
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.ros_image import Level, camera_info, diagnostics, image_message
from palpate.sensor.ros_message import Message, header_of
from palpate.sensor.ros_reading import dots_message, pose_message, pose_with_covariance, wrench_stamped

TOPICS = {
    "image_raw": "sensor_msgs/msg/Image",
    "camera_info": "sensor_msgs/msg/CameraInfo",
    "pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "wrench": "geometry_msgs/msg/WrenchStamped",
    "dots": "sensor_msgs/msg/PointCloud2",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}
"""Published topics and their types."""
_LOST = (Flag.UNREADABLE, Flag.FEW_MARKERS)
Publish = Callable[[str, Message], None]


class RosSpec(SensorLaunchSpec):
    """Parameters of the node."""

    frame: str = parameter("dome", unit="", meaning="frame of pose, wrench and markers")
    camera_frame: str = parameter("camera_optical", unit="", meaning="frame of images")
    retry_s: float = parameter(1.0, unit="s", meaning="time between two tries to open a lost camera", gt=0)


class RosSensor:
    """Open sensor whose readings become messages.

    `publish` is called with every topic and message, in the thread that runs `follow`.

    Raises
    ------
    PalpateError
        As `open_from_parameters`.
    """

    def __init__(self, spec: RosSpec, publish: Publish) -> None:
        self.spec, self._publish = spec, publish
        self._sensor = open_from_parameters(spec)
        self._image: NDArray[Any] | None = None
        self._reading: Reading | None = None
        self._reader = SourceReader(self, self._publish_last)

    def follow(self) -> None:
        """Read the source until `stop`; a lost camera is reported and reopened."""
        again = not Path(self.spec.source).exists()
        self._reader.run(lambda: open_source(self.spec.source), self.spec.retry_s, again)

    def stop(self) -> None:
        """End `follow` after the current image."""
        self._reader.stop()

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Return the reading of one image; image and reading are published next."""
        self._image = None if isinstance(image, PalpateError) else image
        self._reading = self._sensor.read(image)
        return self._reading

    def _publish_last(self, row: Row) -> None:
        assert self._reading is not None
        now = int(row["taken_s"] * 1e9)
        for topic, message in self._messages(self._reading, now, gone=row["camera"] == GONE):
            self._publish(topic, message)

    def _messages(self, reading: Reading, now: int, gone: bool) -> Iterator[tuple[str, Message]]:
        seen, felt = header_of(now, self.spec.camera_frame), header_of(now, self.spec.frame)
        if self._image is not None:
            yield "image_raw", image_message(self._image, seen)
            yield "camera_info", camera_info(self._sensor.registration.camera, seen)
        fitter = self._sensor.estimator.twin_fit
        if reading.fit is not None and fitter is not None and reading.sighting is not None:
            pose = pose_message(reading.pose[:2], (0.0, 0.0), reading.depth_mm)
            yield "pose", pose_with_covariance(pose, reading.fit.covariance, felt)
            yield "dots", dots_message(fitter.positions(reading.fit), reading.sighting.found, felt)
        if reading.force is not None and reading.fit is not None:
            force = reading.force.vector if reading.touching else np.zeros(3)
            yield "wrench", wrench_stamped(force, felt)
        yield "/diagnostics", self._state(reading, felt, gone)

    def _state(self, reading: Reading, header: Message, gone: bool) -> Message:
        lost = gone or any(flag in _LOST for flag in reading.flags)
        level = Level.ERROR if lost else Level.WARN if reading.flags else Level.OK
        values = {
            "image": str(reading.image),
            "touching": str(reading.touching).lower(),
            "found": str(reading.found),
            "latency_ms": f"{reading.latency_ms:.2f}",
            "rest_moved_px": "" if reading.rest is None else f"{reading.rest.rms_px:.3f}",
        }
        says = "; ".join([*reading.flags, *([reading.reason] if reading.reason else [])])
        return diagnostics(level, f"palpate: {self.spec.frame}", says or "good", values, header)
