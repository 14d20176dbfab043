"""What a person may choose about the virtual bench: how well the unit is built, how it is pressed and seen."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, model_validator
from pydantic_core import PydanticCustomError

from palpate.calibration import RobotUncertainty, ToleranceSpec
from palpate.camera import RenderSpec
from palpate.core import Spec, parameter
from palpate.fea import check_contact

DEGRADED = RenderSpec(vignetting=0.35, unevenness=0.2, glare=25.0, blur_px=0.8, noise=3.0, dirt=15, rim=True)
"""Light, lens and sensor of the bench's images."""


class VirtualBenchSpec(Spec):
    """How the bench presses, looks and counts."""

    units: int = parameter(20, unit="1", meaning="sampled units beside the nominal one", ge=0, le=10_000)
    tilts: int = parameter(
        3, unit="1", meaning="tilts of every unit, drawn from as many equal parts of the range", ge=1, le=100
    )
    max_tilt_deg: float = parameter(12.0, unit="deg", meaning="greatest tilt", gt=0, le=30)
    azimuths: int = parameter(4, unit="1", meaning="directions drawn at random for every tilt", ge=1, le=100)
    depth: float = parameter(8.0, unit="mm", meaning="travel of the wall from first touch", gt=0, le=60)
    depth_step: float = parameter(
        0.7, unit="mm", meaning="travel between two images, other than the training's", flag="step", gt=0, le=10
    )
    min_depth: float = parameter(2.4, unit="mm", meaning="least depth of the images that count", ge=0, le=60)
    contact: Annotated[str | float, BeforeValidator(check_contact)] = parameter(
        "no-slip",
        unit="1",
        meaning="contact of the nominal unit: frictionless, no-slip or the coefficient of friction",
    )
    cells: int | None = parameter(
        None, unit="1", meaning="cells along a meridian; empty: an eighth more than the training's own", ge=4, le=200
    )
    solver: Literal["palpate", "calculix"] = parameter("palpate", unit="", meaning="who solves the presses")
    calibration_presses: int = parameter(
        0, unit="1", meaning="known presses from which each unit is identified beforehand; needs a twin", ge=0, le=5
    )
    inverted: int = parameter(
        0, unit="1", meaning="units, the last ones, whose skin stands in its other state while it is read", ge=0
    )
    robot_tilt_deg: float = parameter(
        RobotUncertainty.tilt_deg,
        unit="deg",
        meaning="standard deviation of the robot's tilts in known presses",
        gt=0,
        le=5,
    )
    robot_depth: float = parameter(
        RobotUncertainty.depth,
        unit="mm",
        meaning="standard deviation of the robot's depths in known presses",
        gt=0,
        le=5,
    )
    zero: bool = parameter(
        True, unit="", meaning="whether the depth's zero is found by a first press before those that count"
    )
    tolerance: ToleranceSpec = ToleranceSpec()
    render: RenderSpec = DEGRADED
    seed: int = parameter(0, unit="1", meaning="seed of units, directions and images", ge=0)

    @model_validator(mode="after")
    def _inverted_units_are_units(self) -> VirtualBenchSpec:
        if self.inverted > self.units:
            raise PydanticCustomError(
                "inverted-exceed-units",
                "{inverted} units are to be inverted, and there are {units}.",
                {"inverted": self.inverted, "units": self.units},
            )
        if self.inverted and self.solver != "palpate":
            raise PydanticCustomError(
                "inverted-needs-own-solver",
                "only palpate's own solver presses inverted units, not {solver}.",
                {"solver": self.solver},
            )
        return self

    @model_validator(mode="after")
    def _some_images_count(self) -> VirtualBenchSpec:
        if self.min_depth > self.depth:
            raise PydanticCustomError(
                "images-too-shallow",
                "no image counts: they are {depth} mm deep at most, and from {least} mm on they count.",
                {"depth": f"{self.depth:g}", "least": f"{self.min_depth:g}"},
            )
        return self


class SimulatedRobotSpec(Spec):
    """A robot that is not quite where it says."""

    position_sd_mm: float = parameter(
        0.1, unit="mm", meaning="standard deviation of a place, along each axis", ge=0, le=5
    )
    rotation_sd_deg: float = parameter(
        0.05, unit="deg", meaning="standard deviation of a turn, about each axis", ge=0, le=5
    )
    backlash_mm: float = parameter(0.05, unit="mm", meaning="play along each axis", ge=0, le=5)
    backlash_deg: float = parameter(0.02, unit="deg", meaning="play about each axis", ge=0, le=5)
    compliance: float = parameter(0.02, unit="mm/N", meaning="how far a force pushes the flange back", ge=0, le=2)
    approach_mm: float = parameter(
        2.0, unit="mm", meaning="how far the wall is from where it is believed, either way", ge=0, le=100
    )
    offset_deg: float = parameter(
        1.0, unit="deg", meaning="how far the sensor's axes are from the drill's, about each, either way", ge=0, le=10
    )
    dropout: float = parameter(0.01, unit="1", meaning="share of images that are torn", ge=0, le=1)
