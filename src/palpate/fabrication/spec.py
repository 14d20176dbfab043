"""What a person may choose about how a contact module is made."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

from pydantic import SerializerFunctionWrapHandler, model_serializer

from palpate.core import PAPER, FloatArray, PalpateError, Spec, parameter

ECOFLEX = "Smooth-On technical bulletin, Ecoflex series"


class PadMapping(StrEnum):
    """How a pad carries a flat dot to the dome: along the dome's axis, or to an equal arc from the apex."""

    AXIS = "axis"
    ARC = "arc"


class CameraBody(StrEnum):
    """Camera that the enclosure has a seat for."""

    DAVIS346 = "davis346"
    BOARD28 = "board28"


_SINCE_BARRELS = ("dot_depth", "printer_size")
"""Fields that came with barrels' packs."""


class ProcessSpec(Spec):
    """Mold, print of the markers and enclosure."""

    mold_wall: float = parameter(8.0, unit="mm", meaning="wall of the mold around the flange", ge=6, le=40)
    mold_floor: float = parameter(4.0, unit="mm", meaning="floor of the cavity below the apex", ge=1, le=40)
    plate: float = parameter(6.0, unit="mm", meaning="thickness of the core's plate", ge=3, le=40)
    shrinkage_percent: float = parameter(
        0.1, unit="%", meaning="linear shrinkage of the cured elastomer", source=ECOFLEX, ge=0, le=5
    )
    pin_diameter: float = parameter(4.0, unit="mm", meaning="diameter of the registration pins", ge=2, le=10)
    pin_height: float = parameter(4.0, unit="mm", meaning="height of the registration pins", ge=1, le=20)
    clearance: float = parameter(
        0.15, unit="mm", meaning="gap around a pin, and of parts that are put into each other", ge=0.02, le=1
    )
    pour_diameter: float = parameter(5.0, unit="mm", meaning="diameter of the pour hole", ge=2, le=20)
    vent_diameter: float = parameter(1.5, unit="mm", meaning="diameter of a vent", ge=0.5, le=5)
    vents: int = parameter(6, unit="1", meaning="number of vents at the highest ring of the cavity", ge=2, le=24)
    printer_wall: float = parameter(0.8, unit="mm", meaning="thinnest wall the printer makes", ge=0.1, le=5)
    mapping: PadMapping = parameter(
        PadMapping.AXIS, unit="", meaning="how the pad carries dots: along the axis, or to equal arcs"
    )
    orientation_mark: bool = parameter(
        True, unit="", meaning="print the orientation mark, one dot outside the rings", flag="mark"
    )
    min_marker_diameter: float = parameter(0.4, unit="mm", meaning="smallest dot the pad prints", gt=0, le=5)
    min_gap: float = parameter(0.3, unit="mm", meaning="smallest gap between dots the pad keeps", gt=0, le=5)
    max_slope_deg: float = parameter(
        65.0, unit="deg", meaning="slope of the dome against the base that a pad still reaches", ge=10, le=90
    )
    working_depth: float = parameter(
        8.0, unit="mm", meaning="travel that the sensor is used to", source=PAPER, gt=0, le=40
    )
    working_tilt_deg: float = parameter(
        12.0, unit="deg", meaning="greatest tilt of the wall that it is used at", source=PAPER, ge=0, le=45
    )
    camera_body: CameraBody = parameter(
        CameraBody.BOARD28, unit="", meaning="camera that the enclosure is made for", flag="camera"
    )
    excess_percent: float = parameter(
        30.0, unit="%", meaning="elastomer mixed beyond the module's volume, for cup and sprues", ge=0, le=300
    )
    dot_depth: float = parameter(
        0.4, unit="mm", meaning="depth of a barrel's dots, dimples of its core that ink fills", ge=0.1, le=2
    )
    printer_size: float = parameter(
        300.0, unit="mm", meaning="longest edge of a part that the printer makes", ge=50, le=2000
    )

    def require_room(self, name: str, bounds: FloatArray) -> None:
        """Refuse a part, of least and greatest coordinates (2, 3) mm, that the printer does not make.

        Raises
        ------
        PalpateError
            With its longest edge.
        """
        longest = float((bounds[1] - bounds[0]).max())
        if longest > self.printer_size:
            raise PalpateError(
                f"The part {name} is {longest:.4g} mm long, the printer makes {self.printer_size:g} mm.",
                f"Make the design smaller, or name the size of a larger printer: --printer-size {longest + 0.5:.0f}.",
                code="part-too-long",
            )

    @model_serializer(mode="wrap")
    def _leave_out_what_is_usual(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """What came with barrels is written only where it is another: what was kept before keeps its key."""
        content: dict[str, Any] = dump(self)
        usual = {name: type(self).model_fields[name].default for name in _SINCE_BARRELS}
        return {name: value for name, value in content.items() if name not in usual or value != usual[name]}
