"""Configuration of the fabrication of a contact module."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

from pydantic import SerializerFunctionWrapHandler, model_serializer

from palpate.core import PAPER, FloatArray, PalpateError, Spec, parameter

ECOFLEX = "Smooth-On technical bulletin, Ecoflex series"


class PadMapping(StrEnum):
    """Mapping of a flat dot to the dome by a pad: along the axis, or to an equal arc from the apex."""

    AXIS = "axis"
    ARC = "arc"


class CameraBody(StrEnum):
    """Camera that the enclosure has a seat for."""

    DAVIS346 = "davis346"
    BOARD28 = "board28"


_SINCE_BARRELS = ("dot_depth", "printer_size")
"""Fields that were added for barrels."""


class ProcessSpec(Spec):
    """Dimensions and limits of mold, marker print and enclosure."""

    mold_wall: float = parameter(8.0, unit="mm", meaning="thickness of the mold around the flange", ge=6, le=40)
    mold_floor: float = parameter(4.0, unit="mm", meaning="thickness of the mold below the apex", ge=1, le=40)
    plate: float = parameter(6.0, unit="mm", meaning="thickness of the core's plate", ge=3, le=40)
    shrinkage_percent: float = parameter(
        0.1, unit="%", meaning="linear shrinkage of the cured elastomer", source=ECOFLEX, ge=0, le=5
    )
    pin_diameter: float = parameter(4.0, unit="mm", meaning="diameter of the registration pins", ge=2, le=10)
    pin_height: float = parameter(4.0, unit="mm", meaning="height of the registration pins", ge=1, le=20)
    clearance: float = parameter(
        0.15, unit="mm", meaning="gap around a pin, and between parts that fit into each other", ge=0.02, le=1
    )
    pour_diameter: float = parameter(5.0, unit="mm", meaning="diameter of the pour hole", ge=2, le=20)
    vent_diameter: float = parameter(1.5, unit="mm", meaning="diameter of a vent", ge=0.5, le=5)
    vents: int = parameter(6, unit="1", meaning="number of vents at the highest ring of the cavity", ge=2, le=24)
    printer_wall: float = parameter(0.8, unit="mm", meaning="minimum wall thickness of a printed part", ge=0.1, le=5)
    mapping: PadMapping = parameter(
        PadMapping.AXIS, unit="", meaning="mapping of dots by the pad: along the axis, or to equal arcs"
    )
    orientation_mark: bool = parameter(
        True, unit="", meaning="print the orientation mark, one dot outside the rings", flag="mark"
    )
    min_marker_diameter: float = parameter(0.4, unit="mm", meaning="minimum diameter of a printed dot", gt=0, le=5)
    min_gap: float = parameter(0.3, unit="mm", meaning="minimum gap between printed dots", gt=0, le=5)
    max_slope_deg: float = parameter(
        65.0, unit="deg", meaning="maximum slope of the dome to the base that a pad can print on", ge=10, le=90
    )
    working_depth: float = parameter(
        8.0, unit="mm", meaning="maximum depth of the sensor in use", source=PAPER, gt=0, le=40
    )
    working_tilt_deg: float = parameter(
        12.0, unit="deg", meaning="maximum tilt of the wall in use", source=PAPER, ge=0, le=45
    )
    camera_body: CameraBody = parameter(CameraBody.BOARD28, unit="", meaning="camera of the enclosure", flag="camera")
    excess_percent: float = parameter(
        30.0, unit="%", meaning="elastomer in excess of the module's volume, for cup and sprues", ge=0, le=300
    )
    dot_depth: float = parameter(
        0.4,
        unit="mm",
        meaning="depth of a barrel's dots, which are dimples of its core filled with ink",
        ge=0.1,
        le=2,
    )
    printer_size: float = parameter(300.0, unit="mm", meaning="maximum edge length of a printed part", ge=50, le=2000)

    def require_room(self, name: str, bounds: FloatArray) -> None:
        """Reject a part that is larger than the printer, by its minimum and maximum coordinates (2, 3) mm.

        Raises
        ------
        PalpateError
            If the part's longest edge exceeds `printer_size`.
        """
        longest = float((bounds[1] - bounds[0]).max())
        if longest > self.printer_size:
            raise PalpateError(
                f"The part {name} is {longest:.4g} mm long; the printer size is {self.printer_size:g} mm.",
                f"Make the design smaller, or give the size of a larger printer: --printer-size {longest + 0.5:.0f}.",
                code="part-too-long",
            )

    @model_serializer(mode="wrap")
    def _leave_out_what_is_usual(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out default values of the fields for barrels, so that older artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        usual = {name: type(self).model_fields[name].default for name in _SINCE_BARRELS}
        return {name: value for name, value in content.items() if name not in usual or value != usual[name]}
