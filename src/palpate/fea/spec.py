"""What a user chooses about a press, whatever presses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from pydantic import field_validator

from palpate.core import FloatArray, PalpateError, Spec, parameter
from palpate.design import turn_about_axis
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh

FRICTIONLESS, NO_SLIP = "frictionless", "no-slip"


class ObstacleSpec(Spec, ABC):
    """An obstacle that is brought down on a skin along its axis: what every one has, whatever its shape.

    A half model is symmetric about x = 0 of its mesh; `turn_deg` turns its results to where the obstacle is. An
    obstacle spec of its own adds its numbers and a ``kind`` that names it in files.
    """

    depth: float = parameter(8.0, unit="mm", meaning="travel of the wall from first touch", gt=0, le=60)
    image_step: float = parameter(0.8, unit="mm", meaning="travel between two images", gt=0, le=60)
    unload: bool = False
    """Whether the wall is drawn back to first touch, through the same images."""
    contact: str | float = parameter(
        NO_SLIP,
        unit="1",
        meaning="frictionless, no-slip or the coefficient of friction",
        source="not printed in the paper; the code its group published holds what touches",
    )

    @field_validator("contact", mode="before")
    @classmethod
    def _known_contact(cls, value: Any) -> Any:
        try:
            return read_contact(value)
        except PalpateError as error:
            raise ValueError(str(error)) from None

    @property
    def friction(self) -> float:
        """Coefficient of friction; infinite for no slip."""
        if isinstance(self.contact, str):
            return 0.0 if self.contact == FRICTIONLESS else float("inf")
        return self.contact

    @property
    @abstractmethod
    def words(self) -> str:
        """What tells this obstacle from others like it, in words: ``tilt 5°``."""

    @property
    @abstractmethod
    def radial(self) -> float:
        """How far the pose is from the straight one: tilt in degrees, or offset in mm."""

    @property
    @abstractmethod
    def turn_deg(self) -> float:
        """Turn about the skin's axis from the frame of a half model to the skin's, degrees."""

    @abstractmethod
    def at_touch(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        """The obstacle at first touch and the point (3,) mm that it touches, in the frame of the mesh.

        Raises
        ------
        PalpateError
            If it does not touch the skin first.
        """

    def clamp_depth(self, mesh: Mesh) -> float:
        """Depth in mm at which the obstacle reaches the clamped rim; infinite unless an obstacle can tell."""
        return float("inf")

    def turn(self, mesh: Mesh) -> FloatArray:
        """Rotation (3, 3) from the frame of the mesh to the skin's."""
        return np.eye(3) if mesh.spec.whole else turn_about_axis(np.radians(self.turn_deg))


def read_contact(value: Any) -> str | float:
    """Read a contact law: ``frictionless``, ``no-slip`` or a coefficient of friction from 0 to 10.

    Raises
    ------
    PalpateError
        If it is none of these.
    """
    if value in (FRICTIONLESS, NO_SLIP):
        return str(value)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = -1.0
    if not 0 <= number <= 10:
        raise PalpateError(
            f"The contact law '{value}' is not known.",
            f"Choose {FRICTIONLESS}, {NO_SLIP} or a coefficient from 0 to 10.",
        )
    return number


def contact_text(value: str | float) -> str:
    """Contact law as printed: ``frictionless``, ``no-slip`` or the coefficient."""
    return value if isinstance(value, str) else f"{value:g}"
