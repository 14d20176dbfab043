"""Robots of Universal Robots by the library ur-rtde, in a process of their own."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from contextlib import suppress
from typing import final

from palpate.core import PalpateError, load_extra, parameter
from palpate.rig.remote_robot import RobotLimitsSpec, parse_address
from palpate.rig.tcp_robot import TcpRobot


class UrSpec(RobotLimitsSpec):
    """Limits and speed of a robot of Universal Robots."""

    speed: float = parameter(20.0, unit="mm/s", meaning="speed of the flange", ge=1, le=1000)
    acceleration: float = parameter(200.0, unit="mm/s²", meaning="acceleration of the flange", gt=0, le=10000)
    stall_s: float = parameter(
        0.5,
        unit="s",
        meaning="time without data after which the connection is lost; the controller stops a move after it, too",
        ge=0.1,
        le=10,
    )


@final
class UrRobot(TcpRobot):
    """Robot of Universal Robots, in remote control.

    The controller's tool centre point is set to the flange. The library waits for ever after a lost connection and
    writes to the terminal, so it runs in a process of its own.

    Parameters
    ----------
    text
        Address, and fields of `UrSpec` if they differ from the defaults: ``192.168.0.10?force=30&speed=10``.
    timeout_s
        Maximum time without an answer, s, beyond that of the longest move.
    apart
        Maximum distance of the reported from the commanded pose after a move, mm and degrees.

    Raises
    ------
    PalpateError
        If the library is missing, a setting is refused, or the robot does not answer.
    """

    def __init__(self, text: str, timeout_s: float = 60.0, apart: float = 0.5) -> None:
        host, spec = parse_address(text, "ur", UrSpec)
        load_extra("rtde_control", "ur", "ur-rtde")
        with socket.create_server(("127.0.0.1", 0)) as listening:
            listening.settimeout(0.2)
            port = listening.getsockname()[1]
            command = [sys.executable, "-m", "palpate.rig.ur_bridge", str(port), host, spec.model_dump_json()]
            quiet = subprocess.DEVNULL
            self._process = subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet)
            connection, end = None, time.monotonic() + timeout_s
            while connection is None:
                with suppress(TimeoutError):
                    connection, _ = listening.accept()
                if connection is None and (self._process.poll() is not None or time.monotonic() > end):
                    self._process.kill()
                    raise PalpateError(
                        f"The process of the robot at {host} did not start: exit code {self._process.poll()}.",
                        'Install ur-rtde again: pip install -e ".[ur]"',
                        code="robot-process-failed",
                    )
        connection.settimeout(timeout_s + 2.0 * spec.workspace / spec.speed)
        self._connect(connection, host, apart)
        self.flange_pose()

    def close(self) -> None:
        super().close()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            with suppress(OSError):
                self._process.kill()
