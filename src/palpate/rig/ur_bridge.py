"""Process of a robot of Universal Robots, which translates text lines into calls of ur-rtde.

The first fault ends the process, after the robot is stopped: force above its limit, a pose outside the workspace, a
stop of the controller, a closed connection. If this process or the network fails during a move, the controller stops
the robot, since it no longer receives the signal of its watchdog.
"""

from __future__ import annotations

import os
import socket
import sys
import threading
import time
from typing import Any, NoReturn

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import FloatArray, load_extra
from palpate.rig.ur_robot import UrSpec
from palpate.sensor import Placement

_STOPS = (2, "a protective stop"), (4, "a safeguard stop"), (7, "an emergency stop"), (9, "a fault"), (10, "a stop")
"""Bits of ``safety_status_bits`` and their meaning (RTDE guide, Universal Robots)."""
_VALUES = ["timestamp", "actual_TCP_pose", "actual_TCP_force", "actual_TCP_speed", "safety_status_bits"]
"""Values that the controller sends."""
_PERIOD_S = 0.008
"""Period of the checks, s: 125 Hz is the rate of controllers of the CB series."""
_IDLE_HZ = 1e-3
"""Frequency of the watchdog's signal between moves, when none is sent for minutes."""
_NEAR = 1e-4
"""Distance and speed of a reached pose, m, rad, m/s and rad/s. By hand: 0.1 mm and 0.006°."""


class _Arm:
    """Connection to the controller. Poses and forces are (6,), m, rad, N and N m."""

    def __init__(self, host: str, spec: UrSpec) -> None:
        self._spec = spec
        self._control = load_extra("rtde_control", "ur").RTDEControlInterface(host)
        self._receive = load_extra("rtde_receive", "ur").RTDEReceiveInterface(host, 1.0 / _PERIOD_S, _VALUES)
        self._command("setTcp", [0.0] * 6)
        time.sleep(2.0 * _PERIOD_S)
        self._first, self._force = self._vector("getActualTCPPose"), self._vector("getActualTCPForce")
        offset = self._control.getTCPOffset()
        if len(offset) != 6 or np.abs(offset).max() > _NEAR:
            raise RuntimeError("the controller keeps a tool centre point that is not the flange")
        self._check_force(np.zeros(6))

    def pose(self) -> FloatArray:
        """Return the pose of the flange, if the robot is within its limits."""
        self._check_stop()
        here = self._vector("getActualTCPPose")
        self._check_place(here, "the flange")
        self._check_force(self._force)
        return here

    def move(self, goal: FloatArray) -> None:
        """Move in a straight line, and return on arrival."""
        self._check_place(goal, "the commanded pose")
        self.pose()
        self._command("setWatchdog", 1.0 / self._spec.stall_s)
        self._command("moveL", goal.tolist(), 1e-3 * self._spec.speed, 1e-3 * self._spec.acceleration, True)
        last, since, heard = self._first, time.monotonic(), 0.0
        while not self._arrived(goal):
            here = self.pose()
            if (here != last).any():
                last, since = here, time.monotonic()
            elif time.monotonic() - since > self._spec.stall_s:
                raise RuntimeError("the robot stands still before the end of a move")
            if (sent := self._receive.getTimestamp()) != heard:
                self._control.kickWatchdog()
                heard = sent
            time.sleep(_PERIOD_S)
        self._command("setWatchdog", _IDLE_HZ)

    def stop(self) -> None:
        """Stop the robot and its program."""
        self._control.stopL(10.0)
        self._control.stopScript()

    def watch(self, connection: socket.socket) -> NoReturn:
        """End the process if the controller sends no data, after which the library waits for ever."""
        last, since = -1.0, time.monotonic()
        while True:
            sent = self._receive.getTimestamp()
            if sent != last:
                last, since = sent, time.monotonic()
            elif time.monotonic() - since > self._spec.stall_s:
                connection.sendall(b"error the controller sends no data\n")
                os._exit(1)
            time.sleep(_PERIOD_S)

    def _arrived(self, goal: FloatArray) -> bool:
        here, speed = self._vector("getActualTCPPose"), np.abs(self._vector("getActualTCPSpeed"))
        turn = Rotation.from_rotvec(here[3:]).inv() * Rotation.from_rotvec(goal[3:])
        apart = (speed.max(), np.linalg.norm(here[:3] - goal[:3]), turn.magnitude())
        return all(size < _NEAR for size in apart)

    def _check_place(self, pose: FloatArray, name: str) -> None:
        start, here = (
            Placement(Rotation.from_rotvec(turn).as_matrix(), 1e3 * position)
            for position, turn in (np.split(each, 2) for each in (self._first, pose))
        )
        if breach := self._spec.find_breach(start, here):
            raise RuntimeError(f"{name} {breach}")

    def _check_force(self, zero: FloatArray) -> None:
        force = float(np.linalg.norm((self._vector("getActualTCPForce") - zero)[:3]))
        if not force <= self._spec.force:
            raise RuntimeError(f"the force is {force:.0f} N, over {self._spec.force:g} N")

    def _check_stop(self) -> None:
        bits = int(self._receive.getSafetyStatusBits())
        for bit, name in _STOPS:
            if bits >> bit & 1:
                raise RuntimeError(f"the controller reports {name}")
        if not self._control.isProgramRunning():
            raise RuntimeError("the controller's program was ended")

    def _command(self, name: str, *values: Any) -> None:
        if not getattr(self._control, name)(*values):
            self._check_stop()
            raise RuntimeError(f"the controller refused {name}")

    def _vector(self, name: str) -> FloatArray:
        return np.array(getattr(self._receive, name)(), float)


def _serve(connection: socket.socket, arm: _Arm) -> None:
    """Answer lines until the connection is closed."""
    units = np.repeat([1e-3, np.pi / 180.0], 3)
    for line in connection.makefile("rb"):
        word, *numbers = line.decode("ascii").split()
        answer = "done"
        if word == "move":
            arm.move(np.array(numbers, float) * units)
        else:
            answer = "pose " + " ".join(f"{value:.6f}" for value in arm.pose() / units)
        connection.sendall(f"{answer}\n".encode("ascii"))


def main(port: str, host: str, settings: str) -> None:
    """Serve one connection.

    Parameters
    ----------
    port
        Port of this machine on which `palpate.rig.UrRobot` listens.
    host
        Address of the robot.
    settings
        `UrSpec` as JSON.
    """
    with socket.create_connection(("127.0.0.1", int(port))) as connection:
        try:
            arm = _Arm(host, UrSpec.model_validate_json(settings))
            threading.Thread(target=arm.watch, args=(connection,), daemon=True).start()
            try:
                _serve(connection, arm)
            finally:
                arm.stop()
        except Exception as error:  # the library raises any kind
            line = " ".join(str(error).split()) or type(error).__name__
            connection.sendall(f"error {line}\n".encode("ascii", "replace"))
    os._exit(0)  # the library's destructor may wait for ever


if __name__ == "__main__":
    main(*sys.argv[1:])
