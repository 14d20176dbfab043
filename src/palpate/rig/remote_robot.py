"""Robots behind a connection: addresses, limits of their poses, and errors."""

from __future__ import annotations

from abc import abstractmethod
from typing import TypeVar
from urllib.parse import parse_qsl

import numpy as np
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from palpate.core import PalpateError, Spec, parameter
from palpate.sensor import Placement, Robot

S = TypeVar("S", bound=Spec)


class RobotLimitsSpec(Spec):
    """Limits of the flange's pose and force, from those at the connection."""

    workspace: float = parameter(
        150.0, unit="mm", meaning="maximum distance of the flange from its position at the connection", gt=0, le=1000
    )
    tilt: float = parameter(
        45.0, unit="deg", meaning="maximum angle of the flange's axis from that at the connection", gt=0, le=180
    )

    force: float = parameter(
        50.0,
        unit="N",
        meaning="maximum force at the connection, and maximum change of the force since then",
        gt=0,
        le=500,
    )

    def find_breach(self, first: Placement, here: Placement) -> str:
        """Return how a pose exceeds a limit, in words; empty if it does not."""
        away = float(np.linalg.norm(here.position - first.position))
        if not away <= self.workspace:
            return f"is {away:.0f} mm from the start, over {self.workspace:g} mm"
        axis, start = here.rotation[:, 2], first.rotation[:, 2]
        tilt = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(start, axis)), start @ axis)))
        return "" if tilt <= self.tilt else f"is tilted by {tilt:.0f} degrees from the start, over {self.tilt:g}"


class RemoteRobot(Robot):
    """Robot behind a connection. After a fault the connection is closed, and nothing moves again.

    Parameters
    ----------
    text
        Its address, for messages.
    apart
        Maximum distance of the reported from the commanded pose after a move, mm and degrees.
    """

    def __init__(self, text: str, apart: float) -> None:
        self._text, self._apart = text, apart

    def move(self, base_from_flange: Placement) -> None:
        self._go(base_from_flange)
        here = self.flange_pose()
        off = float(np.linalg.norm(here.position - base_from_flange.position))
        askew = np.degrees(Rotation.from_matrix(here.rotation.T @ base_from_flange.rotation).magnitude())
        if not (off <= self._apart and askew <= self._apart):
            raise self._stop(f"reports a pose {off:.2f} mm and {askew:.2f}° from the one that it was moved to")

    @abstractmethod
    def _go(self, goal: Placement) -> None:
        """Move the flange in a straight line, and return on arrival."""

    def _stop(self, problem: str) -> PalpateError:
        """Close the connection, and return the error."""
        self.close()
        return PalpateError(
            f"The robot at {self._text} {' '.join(problem.split())}.",
            "Check the robot, and start the same command again.",
            code="robot-lost",
        )


def parse_address(text: str, kind: str, spec: type[S]) -> tuple[str, S]:
    """Return host and settings of an address such as ``192.168.0.10?tilt=30&workspace=10``.

    Raises
    ------
    PalpateError
        If there is no host, or a setting is unknown, out of bounds or given twice.
    """
    host, _, query = text.partition("?")
    settings = parse_qsl(query, keep_blank_values=True)
    if not host or len(dict(settings)) < len(settings):
        raise PalpateError(
            f"The address of the robot is '{text}'.",
            f"Give --robot {kind}:HOST, or {kind}:HOST?NAME=VALUE with each name once.",
            code="robot-address",
        )
    try:
        return host, spec.model_validate(dict(settings))
    except ValidationError as error:
        first = error.errors()[0]
        raise PalpateError(
            f"The address of the robot is '{text}', with {first['loc'][0]} = {first['input']}: {first['msg']}.",
            f"Settings of {kind}: {', '.join(spec.model_fields)}.",
            code="robot-setting",
        ) from error
