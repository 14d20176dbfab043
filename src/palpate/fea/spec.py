"""What a person may choose about a press and its solver."""

from __future__ import annotations

from typing import Any

from pydantic import field_validator

from palpate.core import PalpateError, Spec, parameter

FRICTIONLESS, NO_SLIP = "frictionless", "no-slip"


class WallSpec(Spec):
    """A rigid flat wall turned by a tilt about an axis of the base plane and moved along the dome's axis."""

    tilt_deg: float = parameter(0.0, unit="deg", meaning="angle between wall normal and dome axis", ge=0, le=30)
    azimuth_deg: float = parameter(
        0.0, unit="deg", meaning="direction of the rotation axis: (rx, ry) = tilt (cos, sin)", ge=-360, le=360
    )
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
        if value in (FRICTIONLESS, NO_SLIP):
            return value
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = -1.0
        if not 0 <= number <= 10:
            raise ValueError(f"contact is '{value}'; choose {FRICTIONLESS}, {NO_SLIP} or a coefficient from 0 to 10")
        return number

    @property
    def friction(self) -> float:
        """Coefficient of friction; infinite for no slip."""
        if isinstance(self.contact, str):
            return 0.0 if self.contact == FRICTIONLESS else float("inf")
        return self.contact


class SolverSpec(Spec):
    """How a press is solved. The defaults hold 1 % in force and marker displacement over the paper's grid."""

    backend: str = "auto"
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


def read_contact(text: str) -> str | float:
    """Read a contact law from the command line.

    Raises
    ------
    PalpateError
        If it is neither ``frictionless``, ``no-slip`` nor a number from 0 to 10.
    """
    try:
        return WallSpec(contact=text).contact
    except ValueError:
        raise PalpateError(
            f"The contact law '{text}' is not known.",
            f"Choose {FRICTIONLESS}, {NO_SLIP} or a coefficient from 0 to 10.",
        ) from None
