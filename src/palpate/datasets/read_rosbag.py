"""Recordings as ROS bags: images of one topic, and poses and forces at their time stamps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from palpate.camera import decode_image
from palpate.core import FloatArray, IntArray, PalpateError, load_extra, load_opencv
from palpate.datasets.recording_images import ImageSet, Item, SeparateImages, file_stamp
from palpate.datasets.recording_reader import RecordingReader, reading
from palpate.datasets.samples import LEAST_SAMPLES, Samples, find_offset, shrink
from palpate.datasets.table import Column, RecordingTable

_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_POSES = (
    *("geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/TransformStamped", "nav_msgs/msg/Odometry"),
    *("geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/Pose", "geometry_msgs/msg/Transform"),
)
_FORCES = ("geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/Wrench")
_REMEDY = "Give a rosbag1 (.bag), or a rosbag2 (folder, .mcap or .db3)."
_PARTS = 40
"""Maximum number of parts of equal duration that count as presses. By hand."""
_PAUSE = 5.0
"""Time between two images, over its median, from which a new press begins. By hand."""
_LIFT = 0.2
"""Minimum travel of the tool back along its axis between two presses, over its whole travel. By hand."""
_MOSAICS = {"rggb": "BG", "bggr": "RG", "gbrg": "GR", "grbg": "GB"}
"""Bayer mosaics by ROS, and OpenCV's names of the same: their second row, second and third column."""


@final
class RosbagReader(RecordingReader):
    """Bags of ROS 1 and ROS 2; `image` and `pose` are topics. Reading needs the extra ``ros``."""

    formats = "ROS bags (.bag, .mcap, .db3, rosbag2 folders)"
    has_topics = True

    @classmethod
    def accepts(cls, place: Path) -> bool:
        about = place / "metadata.yaml"
        if about.is_file():
            return b"rosbag2" in about.read_bytes()[:200]
        return place.is_file() and place.suffix.lower() in (".bag", ".mcap", ".db3")

    def read(self, place: Path) -> tuple[RecordingTable, ImageSet]:
        load_extra("rosbags.highlevel", "ros", "rosbags")
        with reading(place.name, _REMEDY), _open(place) as bag:
            return self._read(place, bag)

    def _read(self, place: Path, bag: Any) -> tuple[RecordingTable, ImageSet]:
        topics = {
            kinds: [one for one in bag.connections if one.msgtype in kinds] for kinds in (_IMAGES, _POSES, _FORCES)
        }
        for kinds, noun in ((_IMAGES, "images"), (_POSES, "poses")):
            if not topics[kinds]:
                held = ", ".join(f"{one.topic} ({one.msgtype})" for one in bag.connections[:8])
                raise PalpateError(
                    f"{place.name} has no {noun}; it has {held or 'no messages'}.",
                    f"Record a topic of {', '.join(kinds[:3])}.",
                    code="recording-no-images" if noun == "images" else "recording-no-table",
                )
        images = self._pick(place, topics[_IMAGES], self.image, "--image")
        poses = self._pick(place, topics[_POSES], self.pose, "--pose")
        shots = _Shots(place, images, *_image_times(bag, images))
        moved = _samples(bag, poses, _pose_values)
        turned = Rotation.from_quat(moved.values[:, 3:])
        ways = (
            (turned[:-1].inv() * turned[1:]).magnitude(),
            np.linalg.norm(np.diff(moved.values[:, :3], axis=0), axis=1),
        )
        offset, notes = find_offset(shots.times_s, shots.small, moved.time, ways, "poses")
        time = shots.times_s - offset
        within = moved.surround(time)
        if not within.any():
            raise PalpateError(
                f"{place.name}: no image of {images.topic} has a pose of {poses.topic} at its time.",
                "Record both at the same time, with the same clock.",
                code="recording-no-table",
            )
        if not within.all():
            notes += (f"{int((~within).sum())} of {len(within)} images have no pose at their time and are left out",)
        shots.rows = np.flatnonzero(within)
        time = time[within]
        turns, places = Slerp(moved.time, turned)(time).as_quat(), moved.at(time)
        columns: dict[str, Column] = {f"{axis}_m": places[:, number] for number, axis in enumerate("xyz")}
        columns |= {f"q{axis}": turns[:, number] for number, axis in enumerate("xyzw")}
        if len(topics[_FORCES]) == 1:
            forces = _samples(bag, topics[_FORCES][0], _force_values).at(time)
            columns |= dict(zip(("fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm"), forces.T, strict=True))
        axis = Rotation.from_quat(turns).as_matrix()[:, :, 2].mean(axis=0)
        columns["press"], note = _presses(time, places[:, :3] @ axis)
        return RecordingTable(place.name, columns, {}, (*notes, note)), shots

    def _pick(self, place: Path, found: Sequence[Any], asked: str, flag: str) -> Any:
        """Return the one topic that is meant."""
        exact = [one for one in found if one.topic.strip("/") == asked.strip("/")] if asked else list(found)
        if len(exact) == 1:
            return exact[0]
        names = ", ".join(one.topic for one in found)
        raise PalpateError(
            f"{place.name} has the topics {names}" + (f", not {asked}." if asked else "."),
            f"Choose one, such as {flag} {found[0].topic}.",
            code="recording-several-topics",
        )


def _open(place: Path) -> Any:
    highlevel, typesys = (load_extra(f"rosbags.{name}", "ros", "rosbags") for name in ("highlevel", "typesys"))
    return highlevel.AnyReader([place], default_typestore=typesys.get_typestore(typesys.Stores.ROS2_HUMBLE))


def _stamp_s(message: Any, bag_ns: int) -> float:
    """Return the time of a message's header, or of its record if the header has no time, s."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    seconds = 0.0 if stamp is None else float(stamp.sec) + 1e-9 * float(stamp.nanosec)
    return seconds or 1e-9 * bag_ns


def _image_times(bag: Any, topic: Any) -> tuple[IntArray, FloatArray, FloatArray]:
    """Times in the bag (n,) ns, times of the headers (n,) s, and small images (n, h, w) for their change."""
    recorded, stamped, small = [], [], []
    for connection, bag_ns, raw in bag.messages(connections=[topic]):
        message = bag.deserialize(raw, connection.msgtype)
        recorded.append(bag_ns)
        stamped.append(_stamp_s(message, bag_ns))
        try:
            small.append(shrink(_decode(message, f"Image {len(recorded) - 1}")))
        except PalpateError as error:
            small.append(shrink(error))
    return np.array(recorded, np.int64), np.array(stamped), np.array(small, float)


def _samples(bag: Any, topic: Any, values: Any) -> Samples:
    """Messages of a topic in ascending time, each time once."""
    rows = [
        (_stamp_s(message, bag_ns), *values(message))
        for connection, bag_ns, raw in bag.messages(connections=[topic])
        for message in [bag.deserialize(raw, connection.msgtype)]
    ]
    table = np.array(rows, float)
    return Samples.of(table[:, 0], table[:, 1:])


def _pose_values(message: Any) -> tuple[float, ...]:
    body = message
    for name in ("pose", "transform"):  # with covariance, a pose lies in a pose
        while hasattr(body, name):
            body = getattr(body, name)
    place = body.position if hasattr(body, "position") else body.translation
    turn = body.orientation if hasattr(body, "orientation") else body.rotation
    return place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w


def _force_values(message: Any) -> tuple[float, ...]:
    body = getattr(message, "wrench", message)
    return tuple(getattr(part, axis) for part in (body.force, body.torque) for axis in "xyz")


def _presses(time: FloatArray, depth: FloatArray) -> tuple[FloatArray, str]:
    """Number of the press of each image (n,), and a note on it: pauses, lifts, or parts of equal duration."""
    step = np.diff(time)
    begins = np.concatenate([[False], step > _PAUSE * np.median(step)]) if len(step) else np.zeros(len(time), bool)
    press = np.cumsum(begins).astype(float)
    if press[-1] + 1 >= LEAST_SAMPLES:
        return press, f"pauses divide the images into {int(press[-1]) + 1} presses"
    from scipy.signal import find_peaks  # here: its import takes 40 MB

    lifts = find_peaks(-depth, prominence=max(_LIFT * np.ptp(depth), 1e-9))[0]
    if len(lifts) + 1 >= LEAST_SAMPLES:
        press = np.searchsorted(lifts, np.arange(len(time)), side="right").astype(float)
        return press, f"lifts of the tool along its axis divide the images into {len(lifts) + 1} presses"
    count = int(np.clip(len(time) // LEAST_SAMPLES, 1, _PARTS))
    parts = np.floor(np.arange(len(time)) * count / len(time))
    return parts, f"the images follow each other without pauses; {count} parts of equal length count as presses"


def _decode(message: Any, name: str) -> NDArray[Any]:
    """Image (h, w) or (h, w, 3), blue first, of a message."""
    if hasattr(message, "format"):
        return decode_image(bytes(message.data), name)
    encoding = message.encoding.lower()
    kind = np.dtype(np.uint16 if encoding.endswith("16") or "16u" in encoding else np.uint8)
    channels = 3 if encoding[:3] in ("rgb", "bgr") or "uc3" in encoding else 1
    channels = 4 if "a8" in encoding or "8uc4" in encoding else channels
    known = ("mono", "rgb", "bgr", "8uc", "16uc", "bayer")
    if not encoding.startswith(known):
        raise PalpateError(
            f"{name} has the encoding {message.encoding}.",
            f"Known encodings begin with {', '.join(known)}.",
            code="image-encoding-unknown",
        )
    data = np.frombuffer(bytes(message.data), kind.newbyteorder(">" if message.is_bigendian else "<"))
    rows = data.reshape(message.height, message.step // kind.itemsize)[:, : message.width * channels]
    image = rows.reshape(message.height, message.width, channels).astype(kind)
    if encoding.startswith("bayer"):
        cv2, order = load_opencv(), _MOSAICS.get(encoding[6:10], "BG")
        return np.asarray(cv2.cvtColor(image[..., 0], getattr(cv2, f"COLOR_Bayer{order}2GRAY")))
    if channels == 1:
        return np.asarray(image[..., 0])
    return np.ascontiguousarray(image[..., 2::-1] if encoding.startswith("rgb") else image[..., :3])


@final
class _Shots(SeparateImages):
    """Images of one topic; `rows` are those with a pose."""

    def __init__(self, place: Path, topic: Any, bag_ns: IntArray, times_s: FloatArray, small: FloatArray) -> None:
        self._place, self._topic, self._bag_ns = place, topic.topic, bag_ns
        self.times_s, self.small, self.rows = times_s, small, np.arange(len(bag_ns))

    def stamp(self, number: int) -> str:
        file = self._place / "metadata.yaml" if self._place.is_dir() else self._place
        return f"{self._place.name} {file_stamp(file)} {self._topic} {self._bag_ns[self.rows[number]]}"

    def read(self, numbers: Sequence[int]) -> Iterator[Item]:
        if not numbers:
            return
        rows = self.rows[np.asarray(numbers, int)]
        wanted, first, last = set(rows.tolist()), int(rows.min()), int(rows.max())
        row = int(np.searchsorted(self._bag_ns, self._bag_ns[first]))
        with _open(self._place) as bag:
            topics = [one for one in bag.connections if one.topic == self._topic]
            span = {"start": int(self._bag_ns[first]), "stop": int(self._bag_ns[last]) + 1}
            for connection, _, raw in bag.messages(connections=topics, **span):
                if row in wanted:
                    self._deserialize = partial(bag.deserialize, raw, connection.msgtype)
                    yield from super().read([row])
                row += 1

    def image(self, number: int) -> NDArray[Any]:
        return _decode(self._deserialize(), f"Image {number}")
