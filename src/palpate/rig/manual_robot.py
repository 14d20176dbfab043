"""Robot whose poses the user sets with a goniometer or a sine plate, and confirms."""

from __future__ import annotations

import sys
from typing import final

from palpate.core import PalpateError
from palpate.sensor import Placement, Robot


@final
class ManualRobot(Robot):
    """Poses set by the user; the flange is assumed to be at the last confirmed pose.

    The base frame is the flange frame at first contact of the upright sensor. The constructor's text is ignored.
    """

    def __init__(self, text: str = "") -> None:
        self._pose, self._text = Placement(), ""

    def announce(self, text: str) -> None:
        self._text = text

    def move(self, base_from_flange: Placement) -> None:
        sys.stderr.write(f"Set {self._text}; then press Enter: ")
        sys.stderr.flush()
        if not sys.stdin.readline():
            raise PalpateError(
                f"The input ended before the pose was confirmed: {self._text}.",
                "Start the same command again; it resumes.",
                code="robot-lost",
            )
        self._pose = base_from_flange

    def flange_pose(self) -> Placement:
        return self._pose
