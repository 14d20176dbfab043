"""What a person may choose about the virtual bench: how well the unit is built, how it is pressed and seen."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, model_validator
from pydantic_core import PydanticCustomError

from palpate.camera import RenderSpec
from palpate.core import Spec, parameter
from palpate.fea import check_contact

DEGRADED = RenderSpec(vignetting=0.35, unevenness=0.2, glare=25.0, blur_px=0.8, noise=3.0, dirt=15, rim=True)
"""Light, lens and sensor of the bench's images."""


class ToleranceSpec(Spec):
    """How far a built unit may be from its design, either way: what a careful workshop reaches.

    A mold of printed or turned parts measured by a caliper, a syringe and scale for the two components, pad print,
    a camera on a printed holder, calibrated by a board.
    """

    thickness: float = parameter(0.05, unit="mm", meaning="thickness of the wall", ge=0, le=1)
    modulus: float = parameter(
        0.03, unit="1", meaning="stiffness, all constants of the law by one share", ge=0, le=0.9
    )
    stiffening: float = parameter(
        0.1, unit="1", meaning="constants of higher order, over the first of the law", ge=0, le=0.9
    )
    friction: float = parameter(
        0.8,
        unit="1",
        meaning="least coefficient of friction on a clean wall; up to twice that is met; 0: as in the training",
        ge=0,
        le=5,
    )
    dot: float = parameter(0.1, unit="mm", meaning="place of each printed dot, in both directions", ge=0, le=2)
    pad: float = parameter(0.2, unit="mm", meaning="place of the whole print, in both directions", ge=0, le=5)
    missing: float = parameter(0.02, unit="1", meaning="share of dots that are not there", ge=0, le=0.4)
    camera_offset: float = parameter(0.5, unit="mm", meaning="camera off the axis, in both directions", ge=0, le=5)
    camera_distance: float = parameter(0.5, unit="mm", meaning="distance of the camera", ge=0, le=10)
    camera_tilt_deg: float = parameter(1.0, unit="deg", meaning="tilt of the camera about both axes", ge=0, le=10)
    camera_roll_deg: float = parameter(5.0, unit="deg", meaning="turn of the camera about its axis", ge=0, le=180)
    focal: float = parameter(0.003, unit="1", meaning="focal length, left over by the calibration", ge=0, le=0.2)
    centre_px: float = parameter(
        1.0, unit="px", meaning="centre of the lens, left over by the calibration, in both directions", ge=0, le=50
    )
    distortion: float = parameter(
        0.01, unit="1", meaning="first coefficient of the distortion, left over by the calibration", ge=0, le=0.5
    )
    seating_tilt_deg: float = parameter(
        0.1, unit="deg", meaning="tilt of the dome against the robot, about both axes", ge=0, le=5
    )
    seating_turn_deg: float = parameter(
        0.3, unit="deg", meaning="turn of the dome about its axis against the robot", ge=0, le=30
    )
    touch: float = parameter(
        1.0,
        unit="mm",
        meaning="depth that the robot takes for the first touch",
        source="depth bias of Zaid et al. 2024, Table 3",
        ge=0,
        le=5,
    )


class VirtualBenchSpec(Spec):
    """How the bench presses, looks and counts."""

    units: int = parameter(20, unit="1", meaning="sampled units beside the nominal one", ge=0, le=10_000)
    tilts: int = parameter(
        3, unit="1", meaning="tilts of every unit, drawn from as many equal parts of the range", ge=1, le=100
    )
    max_tilt_deg: float = parameter(12.0, unit="deg", meaning="greatest tilt", gt=0, le=30)
    azimuths: int = parameter(4, unit="1", meaning="directions drawn at random for every tilt", ge=1, le=100)
    depth: float = parameter(8.0, unit="mm", meaning="travel of the wall from first touch", gt=0, le=60)
    image_step: float = parameter(
        0.7, unit="mm", meaning="travel between two images, other than the training's", flag="step", gt=0, le=10
    )
    least_depth: float = parameter(2.4, unit="mm", meaning="least depth of the images that count", ge=0, le=60)
    contact: Annotated[str | float, BeforeValidator(check_contact)] = parameter(
        "no-slip",
        unit="1",
        meaning="contact of the nominal unit: frictionless, no-slip or the coefficient of friction",
    )
    cells: int | None = parameter(
        None, unit="1", meaning="cells along a meridian; empty: an eighth more than the training's own", ge=4, le=200
    )
    solver: Literal["palpate", "calculix"] = parameter("palpate", unit="", meaning="who solves the presses")
    zero: bool = parameter(
        True, unit="", meaning="whether the depth's zero is found by a first press before those that count"
    )
    tolerance: ToleranceSpec = ToleranceSpec()
    render: RenderSpec = DEGRADED
    seed: int = parameter(0, unit="1", meaning="seed of units, directions and images", ge=0)

    @model_validator(mode="after")
    def _some_images_count(self) -> VirtualBenchSpec:
        if self.least_depth > self.depth:
            raise PydanticCustomError(
                "no_image_counts",
                "no image counts: they are {depth} mm deep at most, and from {least} mm on they count.",
                {"depth": f"{self.depth:g}", "least": f"{self.least_depth:g}"},
            )
        return self
