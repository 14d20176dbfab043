"""A simulated rosbridge_server with MoveIt behind it, written from their public protocols.

Messages are checked by the definitions of ROS 2 (moveit_msgs, geometry_msgs, shape_msgs, std_msgs), as rosbridge does
it: an unknown field, or a value of the wrong type, is refused. The flange moves on straight lines. A goal is reached
within its tolerances only; faults are injected.
"""

import json
import threading
import time
from contextlib import suppress
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

START = np.array([0.4, -0.12, 0.3])
DOWN = Rotation.from_rotvec([0.0, np.pi, 0.0])
"""Position, m, and orientation of the flange at the start."""
SPEED = 2.5
"""Speed of the simulated planner at a fraction of 1, m/s."""

HEADER = {"frame_id": str}
POINT, QUATERNION = dict.fromkeys("xyz", float), dict.fromkeys("xyzw", float)
POSE = {"position": POINT, "orientation": QUATERNION}
STATE = {"is_diff": bool}
REGION = {"primitives": [{"type": int, "dimensions": [float]}], "primitive_poses": [POSE]}
COMMON = {"header": HEADER, "link_name": str, "weight": float}
ANGLES = {f"absolute_{axis}_axis_tolerance": float for axis in "xyz"}
CONSTRAINTS = {
    "position_constraints": [{**COMMON, "target_point_offset": POINT, "constraint_region": REGION}],
    "orientation_constraints": [{**COMMON, "orientation": QUATERNION, **ANGLES, "parameterization": int}],
}
REQUEST = {
    "start_state": STATE,
    "goal_constraints": [CONSTRAINTS],
    "path_constraints": CONSTRAINTS,
    "pipeline_id": str,
    "planner_id": str,
    "group_name": str,
    "num_planning_attempts": int,
    "allowed_planning_time": float,
    "max_velocity_scaling_factor": float,
    "max_acceleration_scaling_factor": float,
}
TYPES = {
    "moveit_msgs/action/MoveGroup": {
        "request": REQUEST,
        "planning_options": {
            "planning_scene_diff": {"is_diff": bool, "robot_state": STATE},
            "plan_only": bool,
            "replan": bool,
        },
    },
    "moveit_msgs/srv/GetPositionFK": {"header": HEADER, "fk_link_names": [str], "robot_state": STATE},
    "std_msgs/msg/String": {"data": str},
}
OPERATIONS = {
    "advertise": {"topic", "type"},
    "subscribe": {"topic", "type", "queue_length", "throttle_rate"},
    "publish": {"topic", "msg"},
    "call_service": {"service", "args"},
    "send_action_goal": {"action", "action_type", "args"},
    "cancel_action_goal": {"action"},
}
"""Operation of the rosbridge protocol 2.1 → fields beside ``op`` and ``id``."""


def check_message(value: Any, kind: Any) -> None:
    """Refuse a value that is not of a message type."""
    if isinstance(kind, dict):
        assert set(value) <= set(kind), f"fields {sorted(set(value) - set(kind))} do not exist"
        for name, each in value.items():
            check_message(each, kind[name])
    elif isinstance(kind, list):
        assert isinstance(value, list), f"{value} is not a list"
        for each in value:
            check_message(each, kind[0])
    else:
        assert type(value) is kind, f"{value} is not of {kind}"


class RosBridge:
    """Server of one robot on a free port."""

    def __init__(self) -> None:
        from websockets.sync.server import serve

        self.position, self.turn = START.copy(), DOWN
        self.force = np.array([0.0, 0.0, -8.0])
        self.fault, self.pose_fault, self.stopped, self.heard, self.late_s = "", "", False, [], 0.0
        self.goals: list[dict[str, Any]] = []
        self.names: list[str] = []
        self.advertised: dict[str, str] = {}
        self.places: list[np.ndarray] = []
        self._alive = True
        self._server = serve(self._talk, "127.0.0.1", 0, compression=None)
        self.host = f"127.0.0.1:{self._server.socket.getsockname()[1]}"
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def close(self) -> None:
        self._alive = False
        self._server.shutdown()

    def _talk(self, socket: Any) -> None:
        """Answer one client; goals run in a thread of their own, so that they can be cancelled."""
        from websockets.exceptions import ConnectionClosed

        try:
            for text in socket:
                message = json.loads(text)
                self.heard.append(message["op"])
                try:
                    self._answer(socket, message)
                except AssertionError as error:
                    socket.send(json.dumps({"op": "status", "level": "error", "msg": f"InvalidMessage: {error}"}))
        except ConnectionClosed:
            pass

    def _answer(self, socket: Any, message: dict[str, Any]) -> None:
        operation = message["op"]
        fields = set(message) - {"op", "id", "feedback"}
        assert fields == OPERATIONS[operation], f"{operation} has the fields {fields}"
        if operation == "advertise":
            self.advertised[message["topic"]] = message["type"]
        elif operation == "subscribe":
            assert message["type"] == "geometry_msgs/msg/WrenchStamped"
            threading.Thread(target=self._publish, args=(socket, message["topic"]), daemon=True).start()
        elif operation == "publish":
            assert message["topic"] in self.advertised
            check_message(message["msg"], TYPES[self.advertised[message["topic"]]])
            self.stopped |= message["topic"] == "/trajectory_execution_event" and message["msg"]["data"] == "stop"
        elif operation == "cancel_action_goal":
            self.stopped = True
        elif operation == "call_service":
            check_message(message["args"], TYPES["moveit_msgs/srv/GetPositionFK"])
            assert message["args"]["robot_state"] == {"is_diff": True}, "an empty state is not that of the robot"
            self._answer_pose(socket, message)
        elif operation == "send_action_goal":
            check_message(message["args"], TYPES[message["action_type"]])
            self.goals.append(message["args"])
            self.names.append(message["id"])
            threading.Thread(target=self._move, args=(socket, message), daemon=True).start()

    def _answer_pose(self, socket: Any, message: dict[str, Any]) -> None:
        known = message["args"]["header"]["frame_id"] == "base_link" and message["args"]["fk_link_names"] == ["tool0"]
        pose: Any = {
            "position": dict(zip("xyz", self.position.tolist(), strict=True)),
            "orientation": dict(zip("xyzw", self.turn.as_quat().tolist(), strict=True)),
        }
        values: Any = {"pose_stamped": [{"pose": pose}], "error_code": {"val": 1}}
        answer = {"op": "service_response", "id": message["id"], "values": values, "result": True}
        if not known:
            values["pose_stamped"], values["error_code"] = [], {"val": -18}
        if self.pose_fault == "no pose":
            values["pose_stamped"] = []
        elif self.pose_fault == "null":
            pose["position"]["x"] = None  # rosbridge's text of not a number
        elif self.pose_fault == "large":
            pose["position"]["x"] = 10**400
        elif self.pose_fault == "infinite":
            pose["orientation"]["x"] = float("inf")
        elif self.pose_fault == "no service":
            answer.update(values="Service /compute_fk does not exist", result=False)
        elif self.pose_fault == "text":
            socket.send("not JSON")
            return
        socket.send(json.dumps(answer))

    def _publish(self, socket: Any, topic: str) -> None:
        time.sleep(self.late_s)
        while self._alive and self.fault != "no forces":
            force = self.force + (self.fault == "force") * np.array([0.0, 48.0, -64.0])
            wrench = {"force": dict(zip("xyz", force.tolist(), strict=True)), "torque": {}}
            try:
                socket.send(json.dumps({"op": "publish", "topic": topic, "msg": {"wrench": wrench}}))
            except Exception:  # the client has left
                return
            time.sleep(0.005)

    def _move(self, socket: Any, message: dict[str, Any]) -> None:
        request, options = message["args"]["request"], message["args"]["planning_options"]
        assert request["start_state"]["is_diff"]
        assert options["planning_scene_diff"]["is_diff"]
        (constraints,) = request["goal_constraints"]
        (position,), (orientation,) = constraints["position_constraints"], constraints["orientation_constraints"]
        (region,), (centre,) = position["constraint_region"].values()
        assert region["type"] == 2
        assert len(region["dimensions"]) == 1
        goal = np.array([centre["position"][axis] for axis in "xyz"])
        turn = Rotation.from_quat([orientation["orientation"][axis] for axis in "xyzw"])
        error, status = 1, 4
        if request["group_name"] != "manipulator":
            error, status = -15, 6
        elif self.fault == "planning":
            error, status = -1, 6
        else:
            error, status = self._travel(socket, goal, turn, SPEED * request["max_velocity_scaling_factor"])
        if status:
            values = {"error_code": {"val": error, "message": "", "source": ""}, "planning_time": 0.01}
            self._send(socket, "action_result", message["id"], values=values, status=status, result=True)

    def _travel(self, socket: Any, goal: np.ndarray, turn: Rotation, speed: float) -> tuple[int, int]:
        """Move to a pose; MoveIt's code and the status of the action, or 0 without an answer."""
        start, swing = self.position, Slerp([0.0, 1.0], Rotation.concatenate([self.turn, turn]))
        duration, begin = max(float(np.linalg.norm(goal - start)) / speed, 0.002), time.monotonic()
        self.stopped, part = False, 0.0
        while part < 1.0:
            part = min((time.monotonic() - begin) / duration, 1.0)
            if self.stopped or not self._alive:
                return -7, 5
            if part > 0.5:
                if self.fault == "control":
                    return -4, 6
                if self.fault == "drop":
                    socket.close()
                    return 0, 0
                if self.fault == "silence":
                    return 0, 0
                if self.fault == "short":
                    return 1, 4
                if self.fault == "aborted":
                    return 1, 6
            self.position, self.turn = start + part * (goal - start), swing(part)
            self.places.append(self.position)
            time.sleep(0.002)
        return 1, 4

    def _send(self, socket: Any, operation: str, name: str, **fields: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        with suppress(ConnectionClosed):
            socket.send(json.dumps({"op": operation, "id": name, "action": "/move_action", **fields}))
