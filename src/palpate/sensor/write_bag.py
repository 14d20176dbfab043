"""Readings as a rosbag2: poses of the wall for ROS, and every reading as JSON.

`/palpate/pose` (geometry_msgs/PoseStamped, frame ``dome``) holds the rotation (rx, ry) as a quaternion, or the
position (x, y) of an obstacle that does not tilt, and as z minus the depth since first contact, in metres; an image
without a pose has no message. `/palpate/force` (geometry_msgs/WrenchStamped) holds the force on the wall (N, same
frame), if it is estimated. `/palpate/reading` (std_msgs/String) holds every reading by the columns of the CSV
files.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import PalpateError, load_extra, wrap_write_errors
from palpate.sensor.reading import Reading
from palpate.sensor.ros_message import Message, build_message, header_of
from palpate.sensor.ros_reading import pose_message, pose_stamped, wrench_stamped

_VERSION = 9
"""Version of the bag's metadata: ROS 2 Jazzy and later."""
_FRAME = "dome"
"""Frame of poses and forces: the sensor's."""


class Bag:
    """Writer of a rosbag2."""

    def __init__(self, folder: Path) -> None:
        if folder.exists():
            raise PalpateError(
                f"{folder} exists already.", "A bag is a new folder: choose another name.", code="folder-exists"
            )
        rosbag2 = load_extra("rosbags.rosbag2", "ros", "rosbags")
        typesys = load_extra("rosbags.typesys", "ros", "rosbags")
        self._store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
        self._writer = rosbag2.Writer(folder, version=_VERSION)
        with wrap_write_errors(folder, "Choose another folder."):
            self._writer.open()
        self._pose = self._connect("/palpate/pose", "geometry_msgs/msg/PoseStamped")
        self._force = self._connect("/palpate/force", "geometry_msgs/msg/WrenchStamped")
        self._reading = self._connect("/palpate/reading", "std_msgs/msg/String")

    def add(self, reading: Reading, row: dict[str, Any]) -> None:
        """Write one reading and its plain row with the current time."""
        now = time.time_ns()
        if np.isfinite(reading.depth_mm):
            self._write(self._pose, now, pose_stamped(_pose_of(reading), header_of(now, _FRAME)))
        if reading.force is not None and reading.touching:
            self._write(self._force, now, wrench_stamped(reading.force.vector, header_of(now, _FRAME)))
        self._write(self._reading, now, Message("std_msgs/msg/String", {"data": json.dumps(row)}))

    def close(self) -> None:
        """Finish the bag."""
        self._writer.close()

    def _connect(self, topic: str, kind: str) -> Any:
        return self._writer.add_connection(topic, kind, typestore=self._store)

    def _write(self, connection: Any, now: int, message: Message) -> None:
        built = build_message(message, lambda kind, fields: self._store.types[kind](**fields))
        self._writer.write(connection, now, self._store.serialize_cdr(built, connection.msgtype))


def _pose_of(reading: Reading) -> Message:
    first, none = reading.pose[:2], (0.0, 0.0)
    tilt, place = (first, none) if reading.space.is_tilt else (none, first)
    return pose_message(tilt, place, reading.depth_mm)


def write_bag(folder: Path, rows: Iterable[tuple[Reading, dict[str, Any]]]) -> Iterator[Reading]:
    """Write readings as they arrive and yield them; the bag is closed in any case.

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
