"""Robot behind a server of text lines, for controllers that run a small program.

Each request and each answer is one line of ASCII. Numbers are x, y, z of the flange in the base's frame (mm) and its
rotation vector (degrees), separated by spaces::

    pose                            pose 400.0 -120.5 310.0 0.0 180.0 0.0
    move 400.0 -120.5 305.0 0 180 0     done, on arrival on a straight line, or: error TEXT

After a fault the connection is closed, which the server must answer by a stop.
"""

from __future__ import annotations

import socket

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.core import PalpateError
from palpate.rig.remote_robot import RemoteRobot
from palpate.sensor import Placement, rotation_from_vector


class TcpRobot(RemoteRobot):
    """Robot behind a server of text lines.

    Parameters
    ----------
    text
        ``HOST:PORT`` of the server.
    timeout_s
        Maximum time of a move, s.
    apart
        Maximum distance of the reported from the commanded pose after a move, mm and degrees.

    Raises
    ------
    PalpateError
        If the address is malformed, or the server does not answer.
    """

    def __init__(self, text: str, timeout_s: float = 60.0, apart: float = 0.5) -> None:
        host, _, port = text.rpartition(":")
        if not host or not port.isdecimal():
            raise PalpateError(
                f"The address of the robot is '{text}'.", "Give --robot tcp:HOST:PORT.", code="robot-address"
            )
        try:
            connection = socket.create_connection((host, int(port)), timeout_s)
        except (OSError, OverflowError) as error:
            raise PalpateError(
                f"The robot at {text} does not answer: {error}.", "Start its server.", code="robot-lost"
            ) from error
        self._connect(connection, text, apart)

    def _connect(self, connection: socket.socket, text: str, apart: float) -> None:
        super().__init__(text, apart)
        self._socket, self._lines = connection, connection.makefile("rb")

    def _go(self, goal: Placement) -> None:
        turn = Rotation.from_matrix(goal.rotation).as_rotvec(degrees=True)
        numbers = " ".join(f"{value:.6f}" for value in (*goal.position, *turn))
        answer = self._ask(f"move {numbers}")
        if answer != "done":
            raise self._stop(f"answered '{answer}' to a move")

    def flange_pose(self) -> Placement:
        answer = self._ask("pose")
        word, *numbers = answer.split()
        try:
            position, turn = np.array(numbers, float).reshape(2, -1)
            here = Placement(rotation_from_vector(turn), position)
        except ValueError:
            here = Placement(position=np.full(len(numbers), np.nan))
        if word != "pose" or not (np.isfinite(here.position).all() and np.isfinite(here.rotation).all()):
            raise self._stop(f"answered '{answer}' to a request of its pose")
        return here

    def close(self) -> None:
        self._lines.close()
        self._socket.close()

    def _ask(self, request: str) -> str:
        """Send a request, and return the answer, which is not empty."""
        try:
            self._socket.sendall(f"{request}\n".encode("ascii"))
            answer = self._lines.readline().decode("ascii", "replace").strip()
        except (OSError, ValueError) as error:  # a closed connection gives a ValueError
            raise self._stop(f"does not answer: {error}") from error
        if not answer:
            raise self._stop("closed the connection")
        if answer.startswith("error"):
            raise self._stop(f"stopped: {answer[5:].strip() or 'no reason given'}")
        return answer
