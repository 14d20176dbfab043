"""Messages of a sensor: read back by the serialisation of ROS, and true of the press that they tell of."""

from functools import cache

import cv2
import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.calibration import Deviation
from palpate.camera import CameraSpec, RenderSpec
from palpate.design import Design, build_skin, place_markers, wall_normal
from palpate.fea import Press, WallSpec
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import (
    TOPICS,
    Message,
    RosSensor,
    RosSpec,
    build_message,
    header_of,
    parse_launch_spec,
    pose_message,
    pose_with_covariance,
)
from palpate.simulation import SimulatedUnit
from palpate.surrogate import TWIN_DERIVATIVES, write_twin
from presses import build_twin, solve_press
from small_chain import DOME, MARKERS, MATERIAL

SKIN = build_skin(DOME)
LAYOUT = place_markers(SKIN, MARKERS)
LEANING = Deviation(offset_x=0.2, offset_y=-0.1)


def press(tilt_deg: float, azimuth_deg: float = 0.0) -> Press:
    wall = WallSpec(tilt_deg=tilt_deg, azimuth_deg=azimuth_deg, depth=4.0, depth_step=0.5)
    solver = SolverSpec(derivatives=TWIN_DERIVATIVES, edge_share=1.0)
    return solve_press(mesh_skin(SKIN, MeshSpec(cells=6)), MATERIAL, wall, solver)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A twin, and images of a unit at rest, then under a wall of 4° at 30°: 3 mm and 4 mm deep, cut off, 4 mm."""
    folder = tmp_path_factory.mktemp("sensor")
    write_twin(folder / "twin.h5", build_twin([press(tilt) for tilt in (0.0, 3.0, 6.0, 9.0)]))
    scene = SimulatedUnit(Design.of_skin(SKIN, LAYOUT, CameraSpec()), LEANING, RenderSpec(noise=1.0))
    images = [scene.render_rest(), *(list(scene.render_press(pressed()))[k] for k in (6, 8, 8, 8))]
    (folder / "images").mkdir()
    for number, image in enumerate(images):
        cv2.imwrite(str(folder / "images" / f"{number}.png"), image)
    (folder / "images" / "3.png").write_bytes(b"cut off")
    return folder


@cache
def pressed() -> Press:
    return press(4.0, 30.0)


def spec_of(folder, **values):
    chosen = {"twin": str(folder / "twin.h5"), "source": str(folder / "images"), "markers": 37} | values
    return parse_launch_spec(RosSpec, chosen)


@pytest.fixture(scope="module")
def messages(folder):
    """What is published, image by image, and at the end."""
    said = []
    RosSensor(spec_of(folder, lens="", frame="dome"), lambda *each: said.append(each)).follow()
    ends = [k + 1 for k, (topic, _) in enumerate(said) if topic == "/diagnostics"]
    return [dict(said[start:end]) for start, end in zip([0, *ends], ends, strict=False)]


def roundtrip(message):
    """A message as ROS reads it back from its bytes."""
    needs("rosbags.typesys")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    built = build_message(message, lambda kind, fields: store.types[kind](**fields))
    return store.deserialize_cdr(store.serialize_cdr(built, message.kind), message.kind)


def points_of(cloud):
    """Fields of a cloud by their own descriptions."""
    kinds = {6: "<u4", 7: "<f4"}
    layout = np.dtype(
        {
            "names": [field.name for field in cloud.fields],
            "formats": [kinds[field.datatype] for field in cloud.fields],
            "offsets": [field.offset for field in cloud.fields],
            "itemsize": cloud.point_step,
        }
    )
    return np.frombuffer(cloud.data.tobytes(), layout)


def test_every_topic_is_said_and_read_back(messages):
    assert set(messages[2]) == set(TOPICS)
    for topic, message in messages[2].items():
        assert message.kind == TOPICS[topic]
        found = roundtrip(message)
        first = found if topic == "/diagnostics" else roundtrip(messages[2]["image_raw"])
        assert (found.header.stamp.sec, found.header.stamp.nanosec) == (
            first.header.stamp.sec,
            first.header.stamp.nanosec,
        )
        assert found.header.frame_id == ("camera_optical" if topic in ("image_raw", "camera_info") else "dome")


def test_a_pose_is_that_of_the_wall(messages):
    pose = roundtrip(messages[2]["pose"]).pose
    turn = pose.pose.orientation
    rotation = 2 * np.degrees(np.array([turn.x, turn.y, turn.z]))
    assert rotation == pytest.approx([4 * np.cos(np.radians(30)), 4 * np.sin(np.radians(30)), 0.0], abs=0.15)
    assert pose.pose.position.z == pytest.approx(-0.004, abs=5e-5)
    sd = np.sqrt(np.diag(pose.covariance.reshape(6, 6)))
    assert sd[[0, 1, 5]] == pytest.approx(0.0)
    assert 1e-7 < sd[2] < 1e-4
    assert (np.degrees(sd[3:5]) < 0.2).all()


def test_a_covariance_keeps_its_signs_and_units():
    """Depth and rx that grow together: z and the turn about x that go opposite ways."""
    covariance = np.array([[0.04, 0.0, 0.003], [0.0, 0.01, 0.0], [0.003, 0.0, 0.0009]])
    message = pose_with_covariance(pose_message((1.0, 2.0), (0.0, 0.0), 3.0), covariance, header_of(0, "dome"))
    wide = roundtrip(message).pose.covariance.reshape(6, 6)
    drawn = np.random.default_rng(0).multivariate_normal(np.zeros(3), covariance, 200_000)
    plain = np.cov([-drawn[:, 2] / 1e3, np.radians(drawn[:, 0]), np.radians(drawn[:, 1])])
    scale = np.sqrt(np.outer(np.diag(plain), np.diag(plain)))
    assert wide[2:5, 2:5] / scale == pytest.approx(plain / scale, abs=0.02)
    assert wide[2, 3] < 0


def test_dots_are_where_the_press_moved_them_and_where_the_camera_sees_them(messages):
    cloud = points_of(roundtrip(messages[2]["dots"]))
    places = np.column_stack([cloud["x"], cloud["y"], cloud["z"]]) * 1e3
    moved = pressed().positions(LAYOUT.positions)[-1]
    assert cloud["id"].tolist() == list(range(37))
    assert cloud["seen"].sum() >= 35
    assert np.sqrt(np.mean((places - moved) ** 2)) < 0.15
    info = roundtrip(messages[2]["camera_info"])
    k, image = info.k.reshape(3, 3), roundtrip(messages[2]["image_raw"])
    away = places + np.array([0.0, 0.0, CameraSpec().distance])
    pixels = (away @ k.T)[:, :2] / away[:, 2:]
    pictured = image.data.reshape(image.height, image.step)[:, : image.width]
    there = pictured[tuple(pixels.round().astype(int).T[::-1])]
    assert np.median(there) < np.median(pictured) - 20, "a dot is dark, and stands at its pixel"
    assert (info.width, info.height, info.distortion_model, len(info.d)) == (346, 260, "plumb_bob", 5)


def test_a_force_is_that_on_the_wall_and_none_without_a_touch(messages):
    force = roundtrip(messages[2]["wrench"]).wrench.force
    normal = wall_normal(*np.radians([4 * np.cos(np.radians(30)), 4 * np.sin(np.radians(30))]))
    assert np.array([force.x, force.y, force.z]) @ normal == pytest.approx(pressed().force[-1] @ normal, rel=0.1)
    still = roundtrip(messages[0]["wrench"]).wrench.force
    assert (still.x, still.y, still.z) == (0.0, 0.0, 0.0)


def test_what_is_wrong_stands_in_the_diagnostics(messages):
    states = [roundtrip(each["/diagnostics"]).status[0] for each in messages]
    assert [state.level for state in states] == [0, 0, 0, 2, 0, 2]
    assert states[0].message == "good"
    assert states[3].message
    assert "ended" in states[5].message
    assert "pose" not in messages[3]
    values = {pair.key: pair.value for pair in states[2].values}
    assert values["touching"] == "true"
    assert int(values["found"]) >= 35


def test_a_colour_image_says_so():
    from palpate.sensor import image_message

    picture = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    found = roundtrip(image_message(picture[:, ::-1], header_of(0, "c")))
    assert (found.encoding, found.step, found.width) == ("bgr8", 12, 4)
    assert (found.data.reshape(2, 4, 3) == picture[:, ::-1]).all()


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"markers": 8}, ("marker-count-not-rings", "markers", 8)),
        ({"twin": "nowhere.h5"}, ("twin-unreadable", "nowhere.h5")),
        ({"source": "nowhere"}, ("folder-missing", "nowhere")),
        ({"rest_images": 9}, ("rest-images-few", 9)),
        ({"retry_s": 0.0}, ("greater_than", "retry_s")),
        ({"colour": "red"}, ("extra_forbidden", "colour")),
    ],
)
def test_a_wrong_parameter_is_refused_with_a_remedy(folder, values, says):
    with refused(*says) as caught:
        RosSensor(spec_of(folder, **values), print)
    assert caught.value.remedy


def test_messages_nest_and_lists_are_built_inside_out():
    order = []
    message = Message("a", {"x": [Message("b", {"y": 1})], "z": Message("c", {})})
    build_message(message, lambda kind, fields: order.append(kind))
    assert order == ["b", "c", "a"]
