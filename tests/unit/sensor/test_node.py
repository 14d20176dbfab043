"""The node's own lines, run on stand-ins of rclpy and of its message classes, which cannot be installed.

The stand-ins refuse fields of another type as rclpy does in its checks; the states are changed as a manager would.
"""

import sys
import time
from array import array
from pathlib import Path
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

from needs import needs
from palpate.sensor import TOPICS, Level, RosSensor, RosSpec, diagnostics, header_of, image_message

PACKAGE = Path(__file__).parents[3] / "ros" / "palpate_ros"
SUCCESS, FAILURE = "success", "failure"
CODES = {"uint8": "B", "double": "d", "float64": "d"}


def message_class(store, kind):
    """A class that takes the fields of a message, and no others, of the types that rclpy wants."""
    wanted = {}
    for name, (node, rest) in store.fielddefs[kind][1]:
        wanted[name] = ros_kind(int(node), rest)

    def take(self, **fields):
        assert set(fields) <= set(wanted)
        for name, value in fields.items():
            assert fits(value, wanted[name]), (kind, name, wanted[name], type(value))
            setattr(self, name, value)

    owner = kind.replace("/msg/", "/")
    members = {"__init__": take, "get_fields_and_field_types": staticmethod(lambda: dict(wanted)), "owner": owner}
    return type(kind.split("/")[-1], (), members)


def ros_kind(node, rest):
    plain = {"float64": "double", "float32": "float", "bool": "boolean", "byte": "octet"}
    if node == 1:
        return plain.get(rest[0], rest[0])
    if node == 2:
        return rest.replace("/msg/", "/")
    (inner, deeper), length = rest
    kind = ros_kind(int(inner), deeper)
    return f"{kind}[{length}]" if node == 3 else f"sequence<{kind}>"


def fits(value, kind):
    if kind.startswith("sequence<"):
        inner = kind[9:-1]
        if inner in CODES:
            return isinstance(value, array) and value.typecode == CODES[inner]
        return isinstance(value, list) and all(fits(each, inner) for each in value)
    if kind.endswith("]"):
        return isinstance(value, np.ndarray) and value.dtype == float and len(value) == int(kind[:-1].split("[")[1])
    simple = {"double": float, "float": float, "string": str, "boolean": bool, "octet": bytes}
    if "int" in kind and "/" not in kind:
        return type(value) is int
    return type(value) is simple[kind] if kind in simple else value.owner == kind


class Outlet:
    def __init__(self, kind, topic):
        self.kind, self.topic, self.is_activated, self.sent = kind, topic, False, []

    def publish(self, message):
        assert isinstance(message, self.kind)
        self.sent.append(message)


class LifecycleNode:
    def __init__(self, name):
        self.name, self.values, self.outlets, self.errors = name, {}, [], []

    def declare_parameter(self, name, value, descriptor):
        assert isinstance(value, str | int | float | bool)
        assert descriptor.description
        self.values[name] = value

    def get_parameter(self, name):
        return SimpleNamespace(value=self.values[name])

    def get_logger(self):
        return SimpleNamespace(error=self.errors.append)

    def create_lifecycle_publisher(self, kind, topic, queue):
        self.outlets.append(Outlet(kind, topic))
        return self.outlets[-1]

    def destroy_lifecycle_publisher(self, outlet):
        self.outlets.remove(outlet)

    def set_active(self, active):
        for outlet in self.outlets:
            outlet.is_activated = active


@pytest.fixture
def node_class(monkeypatch):
    needs("rosbags.typesys")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    modules = {
        "rclpy": {},
        "rclpy.executors": {"ExternalShutdownException": RuntimeError},
        "rclpy.lifecycle": {
            "LifecycleNode": LifecycleNode,
            "LifecycleState": object,
            "TransitionCallbackReturn": SimpleNamespace(SUCCESS=SUCCESS, FAILURE=FAILURE),
        },
        "rcl_interfaces": {},
        "rcl_interfaces.msg": {"ParameterDescriptor": SimpleNamespace},
    }
    for kind in store.fielddefs:
        package, _, name = kind.split("/")
        if package in ("builtin_interfaces", "std_msgs", "geometry_msgs", "sensor_msgs", "diagnostic_msgs"):
            modules.setdefault(package, {})
            modules.setdefault(f"{package}.msg", {})[name] = message_class(store, kind)
    for name, content in modules.items():
        module = ModuleType(name)
        module.__dict__.update(content)
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.syspath_prepend(str(PACKAGE))
    from palpate_ros.node import SensorNode

    yield SensorNode
    for name in [name for name in sys.modules if name.startswith("palpate_ros")]:
        del sys.modules[name]


def test_a_node_opens_publishes_where_it_is_active_and_closes(node_class, monkeypatch):
    """A sensor that says an image and a state again and again, until it is stopped."""

    class Says(RosSensor):
        def __init__(self, spec, publish):
            assert spec.rest_images == 3
            self._say, self._going = publish, True

        def follow(self):
            while self._going:
                self._say("image_raw", image_message(np.zeros((4, 6), np.uint8), header_of(5, "camera_optical")))
                self._say("/diagnostics", diagnostics(Level.WARN, "a", "b", {"c": "d"}, header_of(5, "dome")))
                time.sleep(0.005)

        def stop(self):
            self._going = False

    monkeypatch.setattr(sys.modules[node_class.__module__], "RosSensor", Says)
    node = node_class()
    assert set(node.values) == set(RosSpec.model_fields)
    node.values |= {"twin": "twin.h5", "rest_images": 3}
    assert node.on_configure(None) == SUCCESS
    assert {outlet.topic for outlet in node.outlets} == set(TOPICS)
    time.sleep(0.05)
    assert not any(outlet.sent for outlet in node.outlets)
    node.set_active(True)
    time.sleep(0.1)
    sent = {outlet.topic: outlet.sent for outlet in node.outlets if outlet.sent}
    assert set(sent) == {"image_raw", "/diagnostics"}
    assert sent["image_raw"][0].data == array("B", bytes(24))
    assert sent["/diagnostics"][0].status[0].level == b"\x01"
    thread = node._thread
    assert node.on_cleanup(None) == SUCCESS
    assert not thread.is_alive()
    assert node.outlets == []


def test_a_node_that_cannot_open_says_why_and_stays_unconfigured(node_class, tmp_path):
    node = node_class()
    node.values |= {"twin": str(tmp_path / "nowhere.h5")}
    assert node.on_configure(None) == FAILURE
    assert "nowhere.h5" in node.errors[0]
    node.values |= {"rest_images": -1}
    assert node.on_configure(None) == FAILURE
    assert "rest_images" in node.errors[1]
    assert node.on_shutdown(None) == SUCCESS


def test_every_message_fits_the_checks_of_rclpy(node_class):
    from palpate.camera import build_camera
    from palpate.sensor import (
        build_message,
        camera_info,
        dots_message,
        pose_message,
        pose_with_covariance,
        wrench_stamped,
    )

    make = sys.modules["palpate_ros.convert"].make_message
    header = header_of(1, "dome")
    pose = pose_message((1.0, 2.0), (0.0, 0.0), 3.0)
    for message in (
        camera_info(build_camera(), header),
        pose_with_covariance(pose, np.eye(3), header),
        wrench_stamped(np.ones(3), header),
        dots_message(np.ones((2, 3)), np.ones(2, bool), header),
        image_message(np.zeros((2, 3, 3), np.uint8), header),
    ):
        built = build_message(message, make)
        assert built.owner == message.kind.replace("/msg/", "/")


def test_the_package_names_its_node_launch_file_and_parameters():
    text = (PACKAGE / "setup.py").read_text()
    root = ElementTree.parse(PACKAGE / "package.xml").getroot()
    assert root.findtext("name") == "palpate_ros"
    assert root.findtext("export/build_type") == "ament_python"
    needed = {kind.split("/")[0] for kind in TOPICS.values()}
    assert needed <= {each.text for each in root.findall("exec_depend")}
    for file in ("launch/sensor.launch.py", "config/sensor.yaml"):
        assert file in text
        assert (PACKAGE / file).is_file()
    compile((PACKAGE / "launch" / "sensor.launch.py").read_text(), "launch", "exec")
    from ruamel.yaml import YAML

    written = YAML(typ="safe").load(PACKAGE / "config" / "sensor.yaml")["/**"]["ros__parameters"]
    assert set(written) == set(RosSpec.model_fields)
    for name, value in written.items():
        default = RosSpec.model_fields[name].default
        assert name == "rest_images" or value == ("" if default in (None, Path()) else default)
