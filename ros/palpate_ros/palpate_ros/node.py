"""The lifecycle node: parameters from `RosSpec`, a thread that reads, a publisher a topic.

Configured, it has the images at rest and reads on; active, it publishes. What it says and when is decided in
`palpate.sensor.RosSensor`, which needs no ROS.
"""

from __future__ import annotations

import sys
from pathlib import Path
from threading import Thread
from typing import Any

import rclpy
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from palpate.core import PalpateError, parameters
from palpate.sensor import TOPICS, Message, RosSensor, RosSpec, build_message, parse_launch_spec
from palpate_ros.convert import make_message, message_type

_QUEUE = 10
_PATIENCE_S = 5.0


class SensorNode(LifecycleNode):
    """A sensor in ROS."""

    def __init__(self) -> None:
        super().__init__("palpate")
        self._names = [note.name for note in parameters(RosSpec)]
        for note in parameters(RosSpec):
            described = ParameterDescriptor(description=note.help)
            self.declare_parameter(note.name, _plain(note.default), described)
        self._outlets: dict[str, Any] = {}
        self._palpate: RosSensor | None = None
        self._thread: Thread | None = None

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Open the sensor; the dome is untouched."""
        try:
            values = {name: self.get_parameter(name).value for name in self._names}
            self._palpate = RosSensor(parse_launch_spec(RosSpec, values), self._publish)
        except PalpateError as error:
            self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        for topic, kind in TOPICS.items():
            self._outlets[topic] = self.create_lifecycle_publisher(message_type(kind), topic, _QUEUE)
        self._thread = Thread(target=self._palpate.follow, daemon=True)
        self._thread.start()
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give the camera back."""
        return self._close()

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give the camera back."""
        return self._close()

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give the camera back; the node may be configured again."""
        return self._close()

    def _publish(self, topic: str, message: Message) -> None:
        """Publish where the node is active; an inactive publisher lets it fall."""
        outlet = self._outlets.get(topic)
        if outlet is not None and outlet.is_activated:
            outlet.publish(build_message(message, make_message))

    def _close(self) -> TransitionCallbackReturn:
        if self._palpate is not None and self._thread is not None:
            self._palpate.stop()
            self._thread.join(_PATIENCE_S)
        for outlet in self._outlets.values():
            self.destroy_lifecycle_publisher(outlet)
        self._outlets, self._palpate, self._thread = {}, None, None
        return TransitionCallbackReturn.SUCCESS


def _plain(default: Any) -> Any:
    """A default as a parameter: no path is an empty text."""
    return "" if default in (None, Path()) else default


def main() -> None:
    """Run the node until it is interrupted."""
    rclpy.init(args=sys.argv)
    node = SensorNode()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
