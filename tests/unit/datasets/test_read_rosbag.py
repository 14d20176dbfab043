"""ROS bags: images, poses and forces of topics at their time stamps, written by rosbags itself."""

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from errors import refused
from needs import needs
from palpate.datasets import ColumnMapping, read_recording
from palpate.datasets.read_rosbag import RosbagReader, _decode, _presses

COUNT, FPS, RATE = 240, 30.0, 125.0
START = 1_700_000_000.0


def course(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 3) m and rotation vectors (n, 3) rad of a smooth motion that never repeats."""
    tilt = 0.15 * np.column_stack([np.sin(0.9 * time + 0.3 * np.sin(2.3 * time)), np.cos(1.3 * time), 0 * time])
    place = np.column_stack([0.3 + 0 * time, 0.1 + 0 * time, 0.2 + 0.002 * np.sin(3.1 * time) * np.sin(0.7 * time)])
    return place, tilt


def picture(time: float) -> np.ndarray:
    """A blob that moves with the tilt, and a bar with the height."""
    place, tilt = course(np.array([time]))
    image = np.full((60, 80), 40, np.uint8)
    cv2.circle(
        image, (int(16 * (40 + 120 * tilt[0, 0])), int(16 * (30 + 120 * tilt[0, 1]))), 16 * 8, 220, -1, cv2.LINE_AA, 4
    )
    image[:, :3] = 128 + 40000 * (place[0, 2] - 0.2)
    return image


class Bag:
    """A bag of ROS 1 or 2 and its messages."""

    def __init__(self, path: Path, kind: str) -> None:
        needs("rosbags")
        from rosbags import rosbag1, rosbag2
        from rosbags.typesys import Stores, get_typestore

        self.is1 = kind == "ros1"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.is1 else Stores.ROS2_HUMBLE)
        if self.is1:
            self.writer = rosbag1.Writer(path)
        else:
            plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
            self.writer = rosbag2.Writer(path, version=8, storage_plugin=plugin)
        self.writer.open()
        self.connections = {}

    def header(self, time: float):
        names = self.store.types
        stamp = names["builtin_interfaces/msg/Time"](int(time), round((time % 1) * 1e9))
        extra = {"seq": 0} if self.is1 else {}
        return names["std_msgs/msg/Header"](**extra, stamp=stamp, frame_id="f")

    def write(self, topic: str, kind: str, message, time: float) -> None:
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        raw = (self.store.serialize_ros1 if self.is1 else self.store.serialize_cdr)(message, kind)
        self.writer.write(self.connections[topic], int(time * 1e9), raw)

    def pose(self, time: float, topic: str = "/robot/pose") -> None:
        names = self.store.types
        place, tilt = course(np.array([time - START]))
        x, y, z, w = Rotation.from_rotvec(tilt[0]).as_quat()
        body = names["geometry_msgs/msg/Pose"](
            names["geometry_msgs/msg/Point"](*place[0]), names["geometry_msgs/msg/Quaternion"](x, y, z, w)
        )
        kind = "geometry_msgs/msg/PoseStamped"
        self.write(topic, kind, names[kind](self.header(time), body), time + 0.004)

    def force(self, time: float) -> None:
        names = self.store.types
        vector, kind = names["geometry_msgs/msg/Vector3"], "geometry_msgs/msg/WrenchStamped"
        body = names["geometry_msgs/msg/Wrench"](vector(0.0, 0.0, 10.0 * (time - START)), vector(0.0, 0.0, 0.0))
        self.write("/force", kind, names[kind](self.header(time), body), time)

    def image(self, time: float, encoding: str, later: float = 0.0, topic: str = "/camera/image") -> None:
        names, image = self.store.types, picture(time - START)
        stamp = self.header(time + later)
        if encoding == "jpeg":
            kind = "sensor_msgs/msg/CompressedImage"
            message = names[kind](stamp, "jpeg", cv2.imencode(".jpg", image)[1].reshape(-1))
        else:
            kind = "sensor_msgs/msg/Image"
            shown = np.dstack([image, image // 2, image // 4]) if encoding in ("rgb8", "bgr8") else image
            shown = shown.astype(np.uint16) * 256 if encoding == "mono16" else shown
            raw = np.pad(shown.reshape(len(image), -1).view(np.uint8), ((0, 0), (0, 16)))  # rows with padding
            message = names[kind](stamp, *image.shape, encoding, 0, raw.shape[1], raw.reshape(-1))
        self.write(topic, kind, message, time + later + 0.01)


def make(path: Path, kind: str = "sqlite", encoding: str = "mono8", later: float = 0.0) -> Path:
    bag = Bag(path, kind)
    events = [(START + k / RATE, "pose") for k in range(int(COUNT / FPS * RATE) + 20)]
    events += [(START + 0.05 + k / FPS, "image") for k in range(COUNT)]
    for time, what in sorted(events):
        if what == "pose":
            bag.pose(time)
            bag.force(time)
        else:
            bag.image(time, encoding, later)
    bag.writer.close()
    return path


@pytest.mark.parametrize(
    ("kind", "encoding"),
    [
        ("ros1", "mono8"),
        ("sqlite", "jpeg"),
        ("mcap", "rgb8"),
        ("sqlite", "bgr8"),
        ("ros1", "mono16"),
        ("mcap", "bayer_rggb8"),
    ],
)
def test_poses_and_forces_are_those_of_the_time_of_each_image(tmp_path: Path, kind: str, encoding: str) -> None:
    path = make(tmp_path / ("a.bag" if kind == "ros1" else "bag"), kind, encoding)
    table, images = RosbagReader().read(path)
    time = 0.05 + np.arange(COUNT) / FPS
    place, tilt = course(time)
    found = np.column_stack([table.columns[f"{axis}_m"] for axis in "xyz"])
    assert found == pytest.approx(place, abs=3e-6)
    turns = Rotation.from_quat(np.column_stack([table.columns[f"q{axis}"] for axis in "xyzw"]))
    assert turns.as_rotvec() == pytest.approx(tilt, abs=2e-5)
    assert table.columns["fz_n"] == pytest.approx(10.0 * time, abs=1e-3)
    first, last = images.read([0, COUNT - 1])
    expected = picture(time[-1])
    grey = last if last.ndim == 2 else last[..., 2 if encoding == "rgb8" else 0]
    tolerance = {"jpeg": 12, "bayer_rggb8": 255}.get(encoding, 0)
    assert np.abs(grey.astype(int) // (256 if encoding == "mono16" else 1) - expected).max() <= tolerance
    assert first.shape[:2] == expected.shape


@pytest.mark.parametrize("later", [-0.35, 0.08, 0.3])
def test_a_clock_offset_is_estimated_from_the_motion(tmp_path: Path, later: float) -> None:
    """The stamps of the images are wrong by it; without a correction the tilt would be up to 4° wrong."""
    table, _ = RosbagReader().read(make(tmp_path / "bag", later=later))
    [note] = [one for one in table.notes if "later" in one]
    told = float(note.split(" ms")[0].split()[-1]) / 1e3
    assert told == pytest.approx(later, abs=0.012)
    place = course(0.05 + np.arange(COUNT) / FPS)[0][:, 2]
    within = slice(COUNT - len(table), None) if later < 0 else slice(0, len(table))
    assert np.abs(table.columns["z_m"] - place[within]).max() < 1.5e-4


def test_a_right_clock_is_left_alone(tmp_path: Path) -> None:
    table, _ = RosbagReader().read(make(tmp_path / "bag"))
    assert not [one for one in table.notes if "later" in one]
    assert len(table) == COUNT


def test_a_bag_is_read_as_a_recording(tmp_path: Path) -> None:
    """Tilt about the axes of the surface; parts of equal length count as presses: neighbours stay together."""
    found = read_recording(make(tmp_path / "bag"), ColumnMapping(frame="300,100,200,0,0,1"))
    assert {"rx", "ry"} <= {one.axis for one in found.poses}
    assert found.presses == 30
    assert any("30 parts" in note for note in found.notes)


def test_lifts_of_the_tool_divide_images_without_pauses_into_presses() -> None:
    """Of 12 presses of 0.6 to 5 mm, lifted by 2 mm, each is whole; their lifts are the ends of the presses."""
    depths = np.linspace(0.6, 5, 12)
    wave = np.sin(np.linspace(0, np.pi, 21))[:-1]
    depth = np.concatenate([(deepest + 2) * wave - 2 for deepest in depths]) + 300
    press, note = _presses(np.arange(len(depth)) / FPS, depth)
    assert press.tolist() == pytest.approx(np.repeat(np.arange(12), 20).tolist())
    assert "12 presses" in note


def test_images_without_a_pose_at_their_time_are_left_out(tmp_path: Path) -> None:
    bag = Bag(tmp_path / "bag", "sqlite")
    for k in range(300):
        if not 100 <= k < 150:
            bag.pose(START + k / RATE)
    for k in range(60):
        bag.image(START + 0.05 + k / FPS, "mono8")
    bag.writer.close()
    table, images = RosbagReader().read(tmp_path / "bag")
    time = 0.05 + np.arange(60) / FPS
    known = (time < 99 / RATE) | (time > 150 / RATE)
    assert len(table) == known.sum() < 60
    assert any(f"{60 - known.sum()} of 60 images" in note for note in table.notes)
    [image] = images.read([int(known[: int(known.argmin()) + 0].sum())])
    assert np.array_equal(image, picture(time[np.flatnonzero(known)[int(known.argmin())]]))


def test_of_several_topics_one_is_chosen(tmp_path: Path) -> None:
    bag = Bag(tmp_path / "bag", "mcap")
    for k in range(200):
        bag.pose(START + k / RATE)
        bag.pose(START + k / RATE, "/other/pose")
    for k in range(30):
        bag.image(START + 0.05 + k / FPS, "mono8")
        bag.image(START + 0.05 + k / FPS, "mono8", topic="/wrist/image")
    bag.writer.close()
    reader = RosbagReader()
    with refused("recording-several-topics", "/wrist/image", "--image"):
        reader.read(tmp_path / "bag")
    reader.image = "wrist/image"
    with refused("recording-several-topics", "/other/pose", "--pose"):
        reader.read(tmp_path / "bag")
    reader.pose = "/nowhere"
    with refused("recording-several-topics", "/nowhere"):
        reader.read(tmp_path / "bag")
    reader.pose = "/other/pose"
    assert len(reader.read(tmp_path / "bag")[0]) == 30


def test_a_topic_of_poses_needs_a_bag(tmp_path: Path) -> None:
    (tmp_path / "poses.csv").write_text("image,rx_deg\na.png,1\n")
    with refused("flag-not-used", "/tool"):
        read_recording(tmp_path / "poses.csv", ColumnMapping(pose="/tool"))


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    for name in ("a.bag", "a.mcap", "a.db3"):
        (tmp_path / name).write_bytes(b"no bag at all")
        with refused("recording-unreadable", name):
            RosbagReader().read(tmp_path / name)
    bag = Bag(tmp_path / "empty", "sqlite")
    bag.pose(START)
    bag.writer.close()
    with refused("recording-no-images", "/robot/pose"):
        RosbagReader().read(tmp_path / "empty")
    bag = Bag(tmp_path / "still", "sqlite")
    bag.image(START, "mono8")
    bag.connections["/robot/pose"] = bag.writer.add_connection(
        "/robot/pose", "geometry_msgs/msg/PoseStamped", typestore=bag.store
    )
    bag.writer.close()
    with refused(("recording-unreadable", "recording-no-table"), "still"):
        RosbagReader().read(tmp_path / "still")
    cut = make(tmp_path / "whole", "mcap") / "whole.mcap"
    (tmp_path / "cut.mcap").write_bytes(cut.read_bytes()[:5000])
    with refused(("recording-unreadable", "recording-no-images", "recording-no-table"), "cut.mcap"):
        RosbagReader().read(tmp_path / "cut.mcap")


def message(encoding: str, pixels: np.ndarray, padding: int = 4, big: int = 0) -> SimpleNamespace:
    """An image message whose rows end in some bytes of padding."""
    rows = np.ascontiguousarray(pixels.reshape(len(pixels), -1)).view(np.uint8)
    raw = np.pad(rows, ((0, 0), (0, padding)), constant_values=7)
    return SimpleNamespace(
        encoding=encoding,
        height=pixels.shape[0],
        width=pixels.shape[1],
        step=raw.shape[1],
        is_bigendian=big,
        data=raw.reshape(-1),
    )


@pytest.mark.parametrize(
    ("encoding", "kind", "channels", "order"),
    [
        ("mono8", "u1", 1, [0]),
        ("8UC1", "u1", 1, [0]),
        ("mono16", "<u2", 1, [0]),
        ("16UC1", ">u2", 1, [0]),
        ("bgr8", "u1", 3, [0, 1, 2]),
        ("rgb8", "u1", 3, [2, 1, 0]),
        ("8UC3", "u1", 3, [0, 1, 2]),
        ("bgra8", "u1", 4, [0, 1, 2]),
        ("rgba8", "u1", 4, [2, 1, 0]),
        ("rgb16", "<u2", 3, [2, 1, 0]),
        ("8UC4", "u1", 4, [0, 1, 2]),
    ],
)
def test_every_encoding_becomes_grey_or_blue_green_red(encoding: str, kind: str, channels: int, order: list) -> None:
    top = 255 if kind == "u1" else 60_000
    pixels = np.random.default_rng(2).integers(0, top, (5, 6, channels)).astype(kind)
    found = _decode(message(encoding, pixels, big=int(kind[0] == ">")), "/camera")
    wanted = pixels[..., 0] if channels == 1 else pixels[..., order]
    assert found.tolist() == wanted.tolist()
    assert found.dtype.itemsize == pixels.dtype.itemsize


def test_an_encoding_that_is_not_known_is_refused() -> None:
    with refused("image-encoding-unknown", "yuv422", "/camera"):
        _decode(message("yuv422", np.zeros((4, 4, 2), np.uint8)), "/camera")


@pytest.mark.parametrize(("image", "key"), [("a/x", "a/x"), ("/b/y/", "b/y"), ("y", "b/y"), ("x", ""), ("z", "")])
def test_a_camera_is_chosen_by_its_whole_name_or_by_the_last_part(image: str, key: str) -> None:
    reader = RosbagReader()
    reader.image = image
    if key:
        assert reader.choose("f", ["a/x", "b.x", "b/y"]) == key
    else:
        with refused("recording-several-cameras" if image == "x" else "column-unknown", "f"):
            reader.choose("f", ["a/x", "b.x", "b/y"])
    reader.image = ""
    assert reader.choose("f", ["only"]) == "only"
