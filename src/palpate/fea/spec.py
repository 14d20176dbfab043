"""Configuration of a press by any obstacle."""

from __future__ import annotations

import math
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
CELLS = (8, 11, 16, 22, 32)
"""Cells from pole to rim of a mesh convergence; each mesh has about twice the elements of the last.
By hand."""
GREATEST_FRICTION = 10.0
"""Maximum coefficient of friction; above it, choose `NO_SLIP`. By hand."""
SAME_MM = 1e-6
"""Difference below which two depths or waypoints are equal."""
_SAME_TURN_DEG = 1e-9
"""Maximum angle in degrees at which an obstacle's plane and a mirror plane of the skin count as equal."""


def check_contact(value: Any) -> str | float:
    """Return a contact law: ``frictionless``, ``no-slip``, or a coefficient of friction as a number.

    Raises
    ------
    ValueError
        If the value is not a contact law; pydantic then rejects the field.
    """
    if value in (FRICTIONLESS, NO_SLIP):
        return str(value)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not 0 <= number <= GREATEST_FRICTION:
        remedy = f"choose {FRICTIONLESS}, {NO_SLIP} or a coefficient from 0 to {GREATEST_FRICTION:g}"
        given = {"given": str(value), "remedy": remedy}
        if math.isnan(number):
            raise PydanticCustomError("contact-unknown", "unknown contact law '{given}'; {remedy}", given)
        raise PydanticCustomError("friction-out-of-bounds", "the coefficient of friction is {given}; {remedy}", given)
    return number or FRICTIONLESS


class ObstacleSpec(Spec, ABC):
    """Obstacle that is pressed on the apex or the side of a skin: parameters common to all obstacles.

    A half model is symmetric about x = 0 of its mesh; `turn_deg` rotates its results to the obstacle's direction. A
    subclass adds its parameters and a ``kind`` that names it in files.
    """

    depth: float = parameter(8.0, unit="mm", meaning="travel of the obstacle from first contact", gt=0, le=60)
    depth_step: float = parameter(
        0.8, unit="mm", meaning="depth between two stored increments", flag="step", gt=0, le=60
    )
    unload: bool = parameter(
        False, unit="", meaning="whether the obstacle is moved back to depth 0, at the same increments"
    )
    contact: Annotated[str | float, BeforeValidator(check_contact)] = parameter(
        NO_SLIP,
        unit="1",
        meaning="contact law: frictionless, no-slip or the coefficient of friction",
        source="not stated in the paper; no-slip in the published code of its group",
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
        """Text that distinguishes this obstacle from others of its kind, such as ``tilt 5°``."""

    @property
    def axisymmetric(self) -> bool:
        """Whether the surface is equal in all directions about the first-contact point, unlike that of a bar.

        The press is then nearly axisymmetric, and is meshed with few cells around that point.
        """
        return True

    @property
    def mirrored(self) -> bool:
        """Whether shape and motion are symmetric about the plane of its tilt or offset."""
        return True

    @property
    def centred(self) -> bool:
        """Whether its shape and motion at tilt or offset 0 are the same at every azimuth."""
        return self.mirrored

    @property
    def moves_laterally(self) -> bool:
        """Whether the obstacle also moves laterally to the skin's axis."""
        return False

    @property
    def sideways(self) -> bool:
        """Whether the obstacle presses the side of a skin that is open at both ends, instead of its apex."""
        return False

    @property
    def stop_depths(self) -> tuple[float, ...]:
        """Depths in mm at which the obstacle's path changes; increments are stored there as well."""
        return ()

    @property
    def pose_space(self) -> PoseSpace:
        """Quantities of the obstacle that a sensor estimates: its offset by default."""
        return OFFSET_SPACE

    @property
    def position_name(self) -> str:
        """Name of the field that a study varies: ``tilt_deg`` of a wall, ``offset`` of any other obstacle."""
        return "tilt_deg" if self.pose_space.is_tilt else "offset"

    @property
    @abstractmethod
    def radial(self) -> float:
        """Magnitude of the pose: tilt in degrees, or offset in mm."""

    @property
    @abstractmethod
    def turn_deg(self) -> float:
        """Rotation about the skin's axis from the frame of a half model to the skin's frame, degrees."""

    @abstractmethod
    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        """Return the obstacle at first contact and the contact point (3,) mm, in the frame of the mesh.

        Raises
        ------
        PalpateError
            If the obstacle does not touch the skin first.
        """

    def path(self, mesh: Mesh) -> Callable[[float], Obstacle]:
        """Return the obstacle as a function of depth in mm: by default moved along its approach axis."""
        return partial(translate_obstacle, self.at_first_contact(mesh)[0], self.approach_axis(mesh))

    def approach_axis(self, mesh: Mesh) -> FloatArray:
        """Return the unit vector (3,) opposite to the motion, in the mesh's frame; by default the skin's axis."""
        return np.array([0.0, 0.0, 1.0])

    def check_skin(self, skin: Skin, rim: Rim = Rim.FLAT) -> None:
        """Raise a `PalpateError` if the obstacle cannot reach the skin, or would touch its rim first."""
        if skin.hole:
            raise PalpateError(
                f"{skin.name} is open at both ends: an obstacle that moves along its axis does not touch it.",
                "Press its side: --obstacle side_wall, or `obstacle: {kind: side_wall}` in a study.",
                code="obstacle-needs-apex",
            )

    def clamp_depth(self, mesh: Mesh) -> float:
        """Return the depth in mm at which the obstacle reaches the clamped rim; infinite by default."""
        return float("inf")

    def turn(self, mesh: Mesh) -> FloatArray:
        """Return the rotation (3, 3) from the frame of the mesh to the skin's frame.

        Raises
        ------
        PalpateError
            If a half model is not symmetric about the obstacle's plane.
        """
        check_half_model(mesh, self)
        return np.eye(3) if mesh.spec.whole else turn_about_axis(np.radians(self.turn_deg))


def check_half_model(mesh: Mesh, obstacle: ObstacleSpec) -> None:
    """Raise a `PalpateError` if the obstacle misses the skin or a half model is asymmetric about it."""
    obstacle.check_skin(mesh.skin, mesh.spec.rim)
    symmetry, name = mesh.skin.symmetry, mesh.skin.name
    if mesh.spec.whole:
        return
    if not obstacle.mirrored:
        raise PalpateError(
            f"Half a skin is not symmetric under this obstacle: {obstacle.label}.",
            "Use a whole mesh: --whole, or MeshSpec(whole=True).",
            code="mesh-whole-needed",
        )
    if symmetry is Symmetry.REVOLVED:
        return
    if symmetry is Symmetry.NONE or min(obstacle.turn_deg % 180, -obstacle.turn_deg % 180) > _SAME_TURN_DEG:
        raise PalpateError(
            f"Half of {name} is not symmetric about the plane of an obstacle turned by {obstacle.turn_deg:g}°.",
            "Mesh the whole skin: --whole, or MeshSpec(whole=True).",
            code="mesh-whole-needed",
        )


def translate_obstacle(obstacle: Obstacle, way: FloatArray, depth: float) -> Obstacle:
    """Return an obstacle at first contact moved by a depth in mm opposite to a unit vector (3,)."""
    return obstacle.moved(-depth * way)
