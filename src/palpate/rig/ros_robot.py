"""Robots of ROS 2: a client of MoveIt's action, by rosbridge."""

from __future__ import annotations

import json
import time
from contextlib import ExitStack, suppress
from typing import Any, final
from urllib.parse import urlsplit
from uuid import uuid4

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray, PalpateError, load_extra, parameter
from palpate.rig.remote_robot import RemoteRobot, RobotLimitsSpec, parse_address
from palpate.sensor import Placement


class RosSpec(RobotLimitsSpec):
    """Names in ROS, limits and speed of a robot."""

    group: str = parameter("manipulator", unit="", meaning="planning group of MoveIt")
    link: str = parameter("tool0", unit="", meaning="link of the flange")
    base: str = parameter("base_link", unit="", meaning="frame of the robot's base")
    pipeline: str = parameter("pilz_industrial_motion_planner", unit="", meaning="planning pipeline of MoveIt")
    planner: str = parameter("LIN", unit="", meaning="planner of the pipeline, for straight lines")
    speed: float = parameter(0.1, unit="1", meaning="fraction of the maximum velocity and acceleration", gt=0, le=1)
    wrench: str = parameter(
        "", unit="", meaning="topic of geometry_msgs/WrenchStamped; without it, forces are not checked"
    )
    force_period: int = parameter(10, unit="ms", meaning="minimum time between two force messages", ge=0, le=100)
    position_tolerance: float = parameter(0.1, unit="mm", meaning="tolerance of a goal's position", gt=0, le=1)
    angle_tolerance: float = parameter(0.05, unit="deg", meaning="tolerance of a goal's orientation", gt=0, le=1)
    planning_s: float = parameter(5.0, unit="s", meaning="maximum time of the planning of a move", gt=0, le=60)
    stall_s: float = parameter(
        0.5, unit="s", meaning="maximum time without a message of the force's topic", ge=0.1, le=10
    )


@final
class RosRobot(RemoteRobot):
    """Robot of ROS 2 with MoveIt and rosbridge_server.

    It moves by the action ``/move_action`` (moveit_msgs/action/MoveGroup), and reads its pose by the service
    ``/compute_fk`` (moveit_msgs/srv/GetPositionFK).

    Parameters
    ----------
    text
        Address of rosbridge_server, and fields of `RosSpec` if they differ from the defaults:
        ``192.168.0.10:9090?group=ur_manipulator&workspace=100``.
    timeout_s
        Maximum time of a request, s.
    apart
        Maximum distance of the reported from the commanded pose after a move, mm and degrees.

    Raises
    ------
    PalpateError
        If the library is missing, a setting is refused, or the robot does not answer.
    """

    def __init__(self, text: str, timeout_s: float = 60.0, apart: float = 0.5) -> None:
        address, self._spec = parse_address(text, "ros2", RosSpec)
        super().__init__(address, apart)
        self._timeout_s, self._forces, self._goal = timeout_s, 0, ""
        self._zero: FloatArray | None = None
        self._connection = ExitStack()
        self._stop_topic = {"topic": "/trajectory_execution_event", "type": "std_msgs/msg/String"}
        client = load_extra("websockets.sync.client", "ros2", "websockets")
        try:
            parts = urlsplit(f"ws://{address}")
            if parts.hostname is None or parts.netloc != address or "@" in address:
                raise ValueError("no host")
            url = f"ws://{address}:9090" if parts.port is None else f"ws://{address}"
        except ValueError as error:
            raise PalpateError(
                f"The address of the robot is '{text}': {error}.",
                "Give --robot ros2:HOST or ros2:HOST:PORT; an IPv6 address in brackets.",
                code="robot-address",
            ) from error
        try:  # messages are received without limit, since forces arrive during pauses, too
            connection = client.connect(
                url, open_timeout=timeout_s, close_timeout=1.0, max_size=None, max_queue=None, proxy=None
            )
            self._socket = self._connection.enter_context(connection)
        except Exception as error:  # of the address, the network and the protocol
            raise PalpateError(
                f"The robot at {address} does not answer: {str(error) or type(error).__name__}.",
                "Start rosbridge_server.",
                code="robot-lost",
            ) from error
        self._send("advertise", **self._stop_topic)
        if self._spec.wrench:
            topic = {"topic": self._spec.wrench, "type": "geometry_msgs/msg/WrenchStamped"}
            self._send("subscribe", **topic, queue_length=1, throttle_rate=self._spec.force_period)
            while self._zero is None:
                self._receive(time.monotonic() + self._timeout_s)
        self._first = self.flange_pose()

    def flange_pose(self) -> Placement:
        values = self._request(
            "call_service",
            service="/compute_fk",
            args={
                "header": {"frame_id": self._spec.base},
                "fk_link_names": [self._spec.link],
                "robot_state": {"is_diff": True},
            },
        )
        try:
            pose = values["pose_stamped"][0]["pose"]
            position = 1e3 * np.array([pose["position"][axis] for axis in "xyz"], float)
            turn = Rotation.from_quat([float(pose["orientation"][axis]) for axis in "xyzw"])
        except (ArithmeticError, LookupError, TypeError, ValueError) as error:
            raise self._stop(f"answered '{values}' to a request of its pose") from error
        here = Placement(turn.as_matrix(), position)
        if not (np.isfinite(here.position).all() and np.isfinite(here.rotation).all()):
            raise self._stop(f"reports a pose that is not finite: {pose}")
        return here

    def _go(self, goal: Placement) -> None:
        for name, place in (("the commanded pose", goal), ("the flange", self.flange_pose())):
            if breach := self._spec.find_breach(self._first, place):
                raise self._stop(f"has limits: {name} {breach}")
        self._request(
            "send_action_goal",
            action="/move_action",
            action_type="moveit_msgs/action/MoveGroup",
            args={
                "request": {
                    "start_state": {"is_diff": True},
                    "goal_constraints": [self._constraints(goal)],
                    "pipeline_id": self._spec.pipeline,
                    "planner_id": self._spec.planner,
                    "group_name": self._spec.group,
                    "num_planning_attempts": 1,
                    "allowed_planning_time": self._spec.planning_s,
                    "max_velocity_scaling_factor": self._spec.speed,
                    "max_acceleration_scaling_factor": self._spec.speed,
                },
                "planning_options": {"planning_scene_diff": {"is_diff": True, "robot_state": {"is_diff": True}}},
            },
        )

    def _constraints(self, goal: Placement) -> dict[str, Any]:
        """Return moveit_msgs/msg/Constraints of a pose."""
        common = {"header": {"frame_id": self._spec.base}, "link_name": self._spec.link, "weight": 1.0}
        *centre, radius = (1e-3 * np.append(goal.position, self._spec.position_tolerance)).tolist()
        point = dict(zip("xyz", centre, strict=True))
        turn = dict(zip("xyzw", Rotation.from_matrix(goal.rotation).as_quat().tolist(), strict=True))
        region = {
            "primitives": [{"type": 2, "dimensions": [radius]}],  # a sphere
            "primitive_poses": [{"position": point, "orientation": {"w": 1.0}}],
        }
        tolerance = float(np.radians(self._spec.angle_tolerance))
        tolerances = {f"absolute_{axis}_axis_tolerance": tolerance for axis in "xyz"}
        return {
            "position_constraints": [{**common, "constraint_region": region}],
            "orientation_constraints": [{**common, "orientation": turn, **tolerances}],
        }

    def _request(self, operation: str, **fields: Any) -> dict[str, Any]:
        """Send a request, and return the values of its answer, after a force has been checked."""
        name = f"palpate-{uuid4().hex}"
        self._goal = name if operation == "send_action_goal" else ""
        self._send(operation, id=name, **fields)
        forces, end = self._forces, time.monotonic() + self._timeout_s
        message: dict[str, Any] = {}
        while message.get("id") != name or message.get("op") not in ("service_response", "action_result"):
            message = self._receive(end)
        self._goal = ""
        values: Any = message.get("values")
        code = values.get("error_code") if isinstance(values, dict) else values
        if not isinstance(code, dict) or code.get("val") != 1:
            raise self._stop(f"answers with the error {code}")
        if message.get("result") is not True or message.get("status") not in (None, 4):  # 4: succeeded
            raise self._stop(f"answers with the status {message.get('status')}")
        while self._spec.wrench and self._forces == forces:
            self._receive(end)
        return dict(values)

    def _receive(self, end: float) -> dict[str, Any]:
        """Return the next message, after checks of errors and forces; `end` is of `time.monotonic`, s."""
        wait = max(end - time.monotonic(), 0.0)
        try:
            text = self._socket.recv(timeout=wait if self._zero is None else min(wait, self._spec.stall_s))
        except TimeoutError as error:
            late = time.monotonic() >= end
            problem = f"did not answer in {self._timeout_s:g} s" if late else f"sends no force on {self._spec.wrench}"
            raise self._stop(problem) from error
        except Exception as error:  # of a closed connection and of the network
            raise self._stop(f"does not answer: {str(error) or type(error).__name__}") from error
        try:
            message = json.loads(text)
            if message["op"] == "publish":
                self._check_force(np.array([message["msg"]["wrench"]["force"][axis] for axis in "xyz"], float))
        except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError) as error:
            raise self._stop(f"sent a message that cannot be read: {error}") from error
        if message["op"] == "status" and message.get("level") == "error":
            raise self._stop(f"refused a request: {message.get('msg')}")
        if time.monotonic() >= end:
            raise self._stop(f"did not answer in {self._timeout_s:g} s")
        return dict(message)

    def _check_force(self, force: FloatArray) -> None:
        """Stop if a force (3,) N exceeds its limit; keep the first one as zero."""
        size = float(np.linalg.norm(force - (0.0 if self._zero is None else self._zero)))
        if not size <= self._spec.force:
            raise self._stop(f"stopped: the force is {size:.0f} N, over {self._spec.force:g} N")
        self._forces += 1
        if self._zero is None:
            self._zero = force

    def _send(self, operation: str, **fields: Any) -> None:
        try:
            self._socket.send(json.dumps({"op": operation, **fields}))
        except Exception as error:  # of a closed connection and of the network
            raise self._stop(f"does not answer: {error}") from error

    def close(self) -> None:
        if self._goal:
            name, self._goal = self._goal, ""
            stop = {"op": "publish", "topic": self._stop_topic["topic"], "msg": {"data": "stop"}}
            cancel = {"op": "cancel_action_goal", "id": name, "action": "/move_action"}
            with suppress(Exception):  # the connection may be lost
                for message in (stop, cancel):
                    self._socket.send(json.dumps(message))
        self._connection.close()
