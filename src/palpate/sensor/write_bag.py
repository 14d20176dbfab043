"""Readings as a rosbag2: poses of the wall for ROS, and every reading as JSON.

`/palpate/pose` (geometry_msgs/PoseStamped, frame ``dome``) holds the rotation (rx, ry) as a quaternion, or the place
(x, y) of an obstacle that does not tilt, and the depth as its z below first touch, in metres; an image without a pose
has none. Where what reads tells it, `/palpate/force` (geometry_msgs/WrenchStamped) holds the force on the wall
(N, same frame). `/palpate/reading` (std_msgs/String) holds every reading by the columns of the other files.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from palpate.built import Force
from palpate.core import PalpateError, load_extra, writing
from palpate.sensor.reading import Reading

_VERSION = 9
"""Version of the bag's metadata: ROS 2 Jazzy and later."""


class Bag:
    """A rosbag2 that is being written."""

    def __init__(self, folder: Path) -> None:
        if folder.exists():
            raise PalpateError(f"{folder} is there already.", "A bag is a new folder: choose another name.")
        rosbag2 = load_extra("rosbags.rosbag2", "ros", "rosbags")
        typesys = load_extra("rosbags.typesys", "ros", "rosbags")
        self._store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
        self._writer = rosbag2.Writer(folder, version=_VERSION)
        with writing(folder, "Choose another folder."):
            self._writer.open()
        self._pose = self._connect("/palpate/pose", "geometry_msgs/msg/PoseStamped")
        self._force = self._connect("/palpate/force", "geometry_msgs/msg/WrenchStamped")
        self._reading = self._connect("/palpate/reading", "std_msgs/msg/String")

    def add(self, reading: Reading, row: dict[str, Any]) -> None:
        """Write one reading and its plain row at the time of now."""
        now = time.time_ns()
        if np.isfinite(reading.depth_mm):
            self._write(self._pose, now, self._pose_of(reading, now))
        if reading.force is not None and reading.touching:
            self._write(self._force, now, self._force_of(reading.force, now))
        self._write(self._reading, now, self._store.types["std_msgs/msg/String"](data=json.dumps(row)))

    def close(self) -> None:
        """Finish the bag."""
        self._writer.close()

    def _connect(self, topic: str, kind: str) -> Any:
        return self._writer.add_connection(topic, kind, typestore=self._store)

    def _write(self, connection: Any, now: int, message: Any) -> None:
        self._writer.write(connection, now, self._store.serialize_cdr(message, connection.msgtype))

    def _pose_of(self, reading: Reading, now: int) -> Any:
        types = self._store.types
        first = np.array([*reading.pose[:2], 0.0])
        rotation, offset = (np.radians(first), np.zeros(3)) if reading.space.tilts else (np.zeros(3), first / 1e3)
        angle = float(np.linalg.norm(rotation))
        vector = 0.5 * np.sinc(angle / (2.0 * np.pi)) * rotation
        place = types["geometry_msgs/msg/Point"](x=float(offset[0]), y=float(offset[1]), z=-reading.depth_mm / 1e3)
        turned = types["geometry_msgs/msg/Quaternion"](*(float(v) for v in vector), w=float(np.cos(angle / 2.0)))
        return types["geometry_msgs/msg/PoseStamped"](
            header=self._header(now),
            pose=types["geometry_msgs/msg/Pose"](position=place, orientation=turned),
        )

    def _force_of(self, force: Force, now: int) -> Any:
        types = self._store.types
        vector = types["geometry_msgs/msg/Vector3"]
        wrench = types["geometry_msgs/msg/Wrench"](
            force=vector(*(float(v) for v in force.vector)), torque=vector(0.0, 0.0, 0.0)
        )
        return types["geometry_msgs/msg/WrenchStamped"](header=self._header(now), wrench=wrench)

    def _header(self, now: int) -> Any:
        stamp = self._store.types["builtin_interfaces/msg/Time"](sec=now // 10**9, nanosec=now % 10**9)
        return self._store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="dome")


def write_bag(folder: Path, rows: Iterable[tuple[Reading, dict[str, Any]]]) -> Iterator[Reading]:
    """Write readings as they come and hand them on; the bag is finished however they end.

    Raises
    ------
    PalpateError
        If the folder exists or cannot be written.
    MissingExtraError
        If rosbags is not installed.
    """
    bag = Bag(folder)
    try:
        for reading, row in rows:
            bag.add(reading, row)
            yield reading
    finally:
        bag.close()
