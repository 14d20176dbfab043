"""One built sensor: its design, its camera, and the camera that its model was trained for."""

from __future__ import annotations

from dataclasses import dataclass, field

from palpate.built import IdentifiedUnit, ToleranceSpec
from palpate.camera import CameraSpec
from palpate.design import MarkerLayout, Skin


@dataclass(frozen=True, eq=False)
class Unit:
    """One built sensor.

    Attributes
    ----------
    skin, layout
        Its design.
    has_orientation_mark
        Whether the orientation mark is printed.
    nominal
        The camera that the model was trained for.
    lens
        Its real lens, from a calibration, and about where it is; `None` for the nominal one.
    identified
        What presses told about it (`palpate identify`).
    tolerance
        How far it may be from its design.
    """

    skin: Skin
    layout: MarkerLayout
    has_orientation_mark: bool = True
    nominal: CameraSpec | None = None
    lens: CameraSpec | None = None
    identified: IdentifiedUnit | None = None
    tolerance: ToleranceSpec = field(default_factory=ToleranceSpec)
