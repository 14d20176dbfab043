"""A device that is asked for images, and readings as a bag."""

import json
from dataclasses import replace

import numpy as np
import pytest

from errors import refused
from made_up_readings import make_fit, make_reading
from needs import needs
from palpate.calibration import Force
from palpate.design import TILT_SPACE, Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.sensor import Device, Flag, Reading, Unit, describe_reading, write_readings
from palpate.simulation import simulate_sensor
from palpate.vision import prepare_detector


@pytest.fixture(scope="module")
def simulated():
    dome = build_skin(DomeSpec())
    layout = place_markers(dome, MarkerSpec(count=37))
    return simulate_sensor(Unit(Design.of_skin(dome, layout)), presses=1)


def test_a_simulated_sensor_stands_behind_the_device(simulated):
    with Device(simulated) as device:
        images = [device.get_image() for _ in range(50)]
        assert device.name == "simulated sensor"
    assert images[0].shape == (260, 346)
    detector = prepare_detector(images[0])
    assert len(detector.find(images[0])) == 38
    moved = [np.abs(image.astype(float) - images[0]).mean() for image in images]
    assert moved[45] > 2 * moved[5]
    assert simulated.truth == pytest.approx((5 * np.cos(np.radians(30)), 5 * np.sin(np.radians(30)), 7.8))


def test_a_device_is_connected_before_it_is_asked_and_says_when_it_ends(simulated):
    device = Device(simulated)
    with refused("sensor-not-connected"):
        device.get_image()
    device.connect()
    for _ in range(10 + 2 * 40):
        device.get_image()
    with refused("source-ended"):
        device.get_image()
    device.disconnect()


def readings():
    bad = Reading.without_pose(TILT_SPACE, Flag.UNREADABLE, reason="cut off")
    return [make_reading([3.0, -4.0, 5.0]), replace(bad, image=2)]


def test_readings_become_a_bag_that_ros_reads(tmp_path):
    rosbag2 = needs("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    assert [reading.image for reading in write_readings(tmp_path / "run.rosbag2", readings())] == [1, 2]
    with rosbag2.Reader(tmp_path / "run.rosbag2") as bag:
        found = [(c.topic, store.deserialize_cdr(raw, c.msgtype)) for c, _, raw in bag.messages()]
    assert [topic for topic, _ in found] == ["/palpate/pose", "/palpate/reading", "/palpate/reading"]
    pose = found[0][1].pose
    turn = pose.orientation
    assert 2 * np.degrees(np.arccos(turn.w)) == pytest.approx(5.0)
    assert turn.y / turn.x == pytest.approx(-4 / 3)
    assert pose.position.z == pytest.approx(-0.005)
    assert json.loads(found[2][1].data)["reason"] == "cut off"
    with refused("folder-exists"):
        list(write_readings(tmp_path / "run.rosbag2", readings()))


def fitted():
    """A reading of a twin: 0.5 N upward and 0.1 N along y, with a hundredth of an N."""
    force = Force(np.array([0.0, 0.1, 0.5]), 1e-4 * np.eye(3), np.array([0.0, 0.0, 1.0]))
    fit = make_fit([3.0, -4.0, 5.0], 1e-4 * np.eye(3), force)
    return make_reading(fit.pose, force=force, fit=fit)


def test_one_component_of_a_reading_is_a_number_for_json():
    assert json.dumps({"rx": readings()[0]["rx_deg"]}) == '{"rx": 3.0}'


def test_forces_and_friction_stand_beside_the_pose(tmp_path):
    row = describe_reading(fitted())
    assert row["normal_force_n"] == pytest.approx(0.5)
    assert row["tangential_force_n"] == pytest.approx(0.1)
    assert row["normal_force_half_width_n"] == pytest.approx(0.01645, rel=1e-3)
    assert row["friction"] == pytest.approx(1.25)
    assert describe_reading(readings()[0])["normal_force_n"] is None
    list(write_readings(tmp_path / "run.csv", [fitted(), *readings()]))
    assert "tangential_force_half_width_n" in (tmp_path / "run.csv").read_text().splitlines()[0]


def test_a_bag_has_the_force_of_a_twin(tmp_path):
    rosbag2 = needs("rosbags.rosbag2")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    list(write_readings(tmp_path / "run.rosbag2", [fitted()]))
    with rosbag2.Reader(tmp_path / "run.rosbag2") as bag:
        found = {c.topic: store.deserialize_cdr(raw, c.msgtype) for c, _, raw in bag.messages()}
    force = found["/palpate/force"].wrench.force
    assert (force.x, force.y, force.z) == pytest.approx((0.0, 0.1, 0.5))
    assert found["/palpate/force"].header.frame_id == "dome"
