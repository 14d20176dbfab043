"""One built sensor: its design, its lens and its calibration."""

from __future__ import annotations

from dataclasses import dataclass, field

from palpate.calibration import IdentifiedUnit, ToleranceSpec
from palpate.camera import CameraSpec
from palpate.design import Design


@dataclass(frozen=True, eq=False)
class Unit:
    """One built sensor.

    Attributes
    ----------
    design
        The design that it was made to; a network was trained for the camera of the design.
    has_orientation_mark
        Whether the orientation mark is printed.
    lens
        Its real lens, from a calibration, and about where it is; `None` for the nominal one.
    identified
        Its parameters from calibration presses (`palpate calibration identify`).
    tolerance
        How far it may be from its design.
    """

    design: Design
    has_orientation_mark: bool = True
    lens: CameraSpec | None = None
    identified: IdentifiedUnit | None = None
    tolerance: ToleranceSpec = field(default_factory=ToleranceSpec)

    @property
    def camera_spec(self) -> CameraSpec:
        """The calibrated lens, or the camera of the design."""
        return self.lens or self.design.camera_spec
