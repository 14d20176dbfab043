"""What a user chooses about a press, whatever presses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from palpate.core import FloatArray, PalpateError, Spec, parameter
from palpate.design import OFFSET_SPACE, PoseSpace, Rim, Skin, Symmetry, turn_about_axis
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh

FRICTIONLESS, NO_SLIP = "frictionless", "no-slip"
GREATEST_FRICTION = 10.0
"""Greatest coefficient of friction; above it, choose `NO_SLIP`."""
_SAME_TURN_DEG = 1e-9
"""Turn of an obstacle's plane from a mirror of the skin below which the two are one, degrees."""


def check_contact(value: Any) -> str | float:
    """Contact law as a spec holds it: ``frictionless``, ``no-slip``, or a coefficient of friction as a number.

    Raises
    ------
    ValueError
        If it is none of them; a spec that has such a field refuses it.
    """
    if value in (FRICTIONLESS, NO_SLIP):
        return str(value)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not 0 <= number <= GREATEST_FRICTION:
        raise PydanticCustomError(
            "contact-unknown",
            "the contact law '{given}' is not known; choose {words} or a coefficient from 0 to {most}",
            {"given": str(value), "words": f"{FRICTIONLESS}, {NO_SLIP}", "most": f"{GREATEST_FRICTION:g}"},
        )
    return number


class ObstacleSpec(Spec, ABC):
    """An obstacle that is brought down on a skin along its axis, or to its side: what every one has.

    A half model is symmetric about x = 0 of its mesh; `turn_deg` turns its results to where the obstacle is. An
    obstacle spec of its own adds its numbers and a ``kind`` that names it in files.
    """

    depth: float = parameter(8.0, unit="mm", meaning="travel of the wall from first touch", gt=0, le=60)
    depth_step: float = parameter(0.8, unit="mm", meaning="travel between two images", flag="step", gt=0, le=60)
    unload: bool = parameter(
        False, unit="", meaning="whether the wall is drawn back to depth 0, through the same increments"
    )
    contact: Annotated[str | float, BeforeValidator(check_contact)] = parameter(
        NO_SLIP,
        unit="1",
        meaning="frictionless, no-slip or the coefficient of friction",
        source="not printed in the paper; the code its group published holds what touches",
    )

    @property
    def friction(self) -> float:
        """Coefficient of friction; infinite for no slip."""
        if isinstance(self.contact, str):
            return 0.0 if self.contact == FRICTIONLESS else float("inf")
        return self.contact

    @property
    def contact_text(self) -> str:
        """Contact law as printed: ``frictionless``, ``no-slip`` or the coefficient."""
        return self.contact if isinstance(self.contact, str) else f"{self.contact:g}"

    @property
    @abstractmethod
    def label(self) -> str:
        """What tells this obstacle from others like it, in words: ``tilt 5°``."""

    @property
    def axisymmetric(self) -> bool:
        """Whether its surface is alike in all directions about the point of first touch; a bar's is not.

        The press by such a one is nearly a body of revolution, and so is meshed with few cells around that point.
        """
        return True

    @property
    def moves_laterally(self) -> bool:
        """Whether it moves other than along the skin's axis."""
        return False

    @property
    def sideways(self) -> bool:
        """Whether it comes to the side of a skin that is open at both ends, rather than down along its axis."""
        return False

    @property
    def stop_depths(self) -> tuple[float, ...]:
        """Depths in mm where its way changes; there are increments there too."""
        return ()

    @property
    def pose_space(self) -> PoseSpace:
        """What a sensor may estimate of it: its place, unless an obstacle says otherwise."""
        return OFFSET_SPACE

    @property
    def position_name(self) -> str:
        """Name of the field that a study varies: ``tilt_deg`` of a wall, ``offset`` of any other obstacle."""
        return "tilt_deg" if self.pose_space.is_tilt else "offset"

    @property
    @abstractmethod
    def radial(self) -> float:
        """How far the pose is from the straight one: tilt in degrees, or offset in mm."""

    @property
    @abstractmethod
    def turn_deg(self) -> float:
        """Turn about the skin's axis from the frame of a half model to the skin's, degrees."""

    @abstractmethod
    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        """The obstacle at first touch and the point (3,) mm that it touches, in the frame of the mesh.

        Raises
        ------
        PalpateError
            If it does not touch the skin first.
        """

    def path(self, mesh: Mesh) -> Callable[[float], Obstacle]:
        """The obstacle at a depth in mm: moved against its way, unless it says otherwise."""
        return partial(translate_obstacle, self.at_first_contact(mesh)[0], self.approach_axis(mesh))

    def approach_axis(self, mesh: Mesh) -> FloatArray:
        """Unit vector (3,) against which it moves, in the frame of the mesh: the skin's axis by default."""
        return np.array([0.0, 0.0, 1.0])

    def check_skin(self, skin: Skin, rim: Rim = Rim.FLAT) -> None:
        """Refuse, with a `PalpateError`, a skin that it cannot come to, or one whose rim it would touch first."""
        if skin.hole:
            raise PalpateError(
                f"{skin.name} is open at both ends: nothing touches it that comes down along its axis.",
                "Press its side: --obstacle side_wall, or `obstacle: {kind: side_wall}` in a study.",
                code="obstacle-needs-apex",
            )

    def clamp_depth(self, mesh: Mesh) -> float:
        """Depth in mm at which the obstacle reaches the clamped rim; infinite unless an obstacle can tell."""
        return float("inf")

    def turn(self, mesh: Mesh) -> FloatArray:
        """Rotation (3, 3) from the frame of the mesh to the skin's.

        Raises
        ------
        PalpateError
            If half a skin was meshed that is not symmetric about the obstacle's plane.
        """
        check_half_model(mesh, self)
        return np.eye(3) if mesh.spec.whole else turn_about_axis(np.radians(self.turn_deg))


def check_half_model(mesh: Mesh, obstacle: ObstacleSpec) -> None:
    """Refuse, with a `PalpateError`, a skin that an obstacle cannot come to, or half a one not symmetric about it."""
    obstacle.check_skin(mesh.skin, mesh.spec.rim)
    symmetry, name = mesh.skin.symmetry, mesh.skin.name
    if mesh.spec.whole or symmetry is Symmetry.REVOLVED:
        return
    if symmetry is Symmetry.NONE or min(obstacle.turn_deg % 180, -obstacle.turn_deg % 180) > _SAME_TURN_DEG:
        raise PalpateError(
            f"Half of {name} is not symmetric about the plane of an obstacle turned by {obstacle.turn_deg:g}°.",
            "Press the whole: MeshSpec(whole=True), --whole.",
            code="mesh-whole-needed",
        )


def translate_obstacle(obstacle: Obstacle, way: FloatArray, depth: float) -> Obstacle:
    """An obstacle that touches the skin, moved by a depth in mm against a unit vector (3,)."""
    return obstacle.moved(-depth * way)
