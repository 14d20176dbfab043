"""What a person may choose about a press and its solver."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from palpate.core import Spec, parameter

FRICTIONLESS, NO_SLIP = "frictionless", "no-slip"
GREATEST_FRICTION = 10.0
"""Greatest coefficient of friction; above it, choose `NO_SLIP`."""


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
            "unknown_contact",
            "the contact law '{given}' is not known; choose {words} or a coefficient from 0 to {most}",
            {"given": str(value), "words": f"{FRICTIONLESS}, {NO_SLIP}", "most": f"{GREATEST_FRICTION:g}"},
        )
    return number


class WallSpec(Spec):
    """A rigid flat wall turned by a tilt about an axis of the base plane and moved along the dome's axis."""

    tilt_deg: float = parameter(0.0, unit="deg", meaning="angle between wall normal and dome axis", ge=0, le=30)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction of the rotation axis: (rx, ry) = tilt (cos, sin)", ge=-360, le=360
    )
    depth: float = parameter(8.0, unit="mm", meaning="travel of the wall from first touch", gt=0, le=60)
    image_step: float = parameter(0.8, unit="mm", meaning="travel between two images", flag="step", gt=0, le=60)
    unload: bool = False
    """Whether the wall is drawn back to first touch, through the same images."""
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


class SolverSpec(Spec):
    """How a press is solved. The defaults hold 1 % in force and marker displacement over the paper's grid."""

    backend: str = parameter("auto", unit="", meaning="linear solver, or auto; `palpate doctor` lists them")
    penalty_ratio: float = parameter(
        60.0,
        unit="1",
        meaning="contact penalty over E/T; ten times more changes the force by less than 0.1 %",
        gt=1,
        le=1e6,
    )
    tangential_ratio: float = parameter(1.0, unit="1", meaning="friction spring over contact penalty", gt=0, le=10)
    smoothing_ratio: float = parameter(
        1e-3, unit="1", meaning="width of the penalty's smooth start over the wall's thickness", gt=0, le=0.1
    )
    adhesion: float = parameter(
        2e-2,
        unit="1",
        meaning="tension over E up to which the flat branch is held; beyond it the dome may turn inside out",
        ge=0,
        le=0.1,
    )
    tolerance: float = parameter(1e-4, unit="1", meaning="greatest residual over mu T²", gt=1e-12, le=1e-2)
    first_step: float = parameter(0.1, unit="mm", meaning="first increment of the wall", gt=0, le=10)
    largest_step: float = parameter(0.8, unit="mm", meaning="largest increment of the wall", gt=0, le=10)
    friction_share: float = parameter(
        1 / 12,
        unit="1",
        meaning="largest increment over the depth where there is friction: points that slide within it lose energy",
        gt=0.01,
        le=1,
    )
    smallest_step: float = parameter(
        1e-3, unit="mm", meaning="smallest increment before the press gives up", gt=0, le=1
    )
    iterations: int = parameter(
        24, unit="1", meaning="Newton iterations before an increment is shortened", ge=4, le=100
    )


def contact_text(value: str | float) -> str:
    """Contact law as printed: ``frictionless``, ``no-slip`` or the coefficient."""
    return value if isinstance(value, str) else f"{value:g}"
