"""Built sensor: its design, lens and calibration."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from palpate.calibration import IdentifiedUnit, ToleranceSpec
from palpate.camera import CameraSpec
from palpate.design import Design


@dataclass(frozen=True, eq=False)
class Unit:
    """One built sensor.

    Attributes
    ----------
    design
        Its design; a network was trained for the camera of the design.
    has_orientation_mark
        Whether the orientation mark is printed.
    lens
        Calibrated lens and approximate camera pose; `None` for the nominal one.
    identified
        Its parameters from calibration presses (`palpate calibration identify`).
    tolerance
        Tolerances of its manufacture.
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

    def at_size(self, width_px: int, height_px: int) -> Unit:
        """Return the unit with its lens scaled to an image size (`CameraSpec.scaled_to`)."""
        scaled = self.camera_spec.scaled_to(width_px, height_px)
        return self if scaled is self.camera_spec else replace(self, lens=scaled)

    def describe_scaling(self, used: CameraSpec) -> str:
        """Sentence that reports the scaling of the lens to an image size; empty without one."""
        own = self.camera_spec
        if (own.width_px, own.height_px) == (used.width_px, used.height_px):
            return ""
        return (
            f"The lens is of {own.width_px} × {own.height_px} px, the image {used.width_px} × {used.height_px} px; "
            f"the lens was scaled by {used.width_px / own.width_px:g}."
        )
