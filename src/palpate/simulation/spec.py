"""Configuration of the simulated test bench and of the simulated robot."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BeforeValidator, model_validator
from pydantic_core import PydanticCustomError

from palpate.calibration import RobotUncertainty, ToleranceSpec
from palpate.camera import RenderSpec
from palpate.core import Spec, parameter
from palpate.fea import check_contact

DEGRADED = RenderSpec(vignetting=0.35, unevenness=0.2, glare=25.0, blur_px=0.8, noise=3.0, dirt=15, rim=True)
"""Light, lens and sensor of the test bench's images."""


class VirtualBenchSpec(Spec):
    """Units, presses, images and solver of a simulated test bench."""

    units: int = parameter(
        20, unit="1", meaning="number of sampled units, in addition to the nominal unit", ge=0, le=10_000
    )
    tilts: int = parameter(
        3, unit="1", meaning="number of tilts per unit, one drawn from each equal part of the range", ge=1, le=100
    )
    max_tilt_deg: float = parameter(12.0, unit="deg", meaning="maximum tilt", gt=0, le=30)
    azimuths: int = parameter(4, unit="1", meaning="number of directions drawn at random per tilt", ge=1, le=100)
    depth: float = parameter(8.0, unit="mm", meaning="travel of the wall from first contact", gt=0, le=60)
    depth_step: float = parameter(
        0.7, unit="mm", meaning="depth between two images, unlike that of the training", flag="step", gt=0, le=10
    )
    min_depth: float = parameter(2.4, unit="mm", meaning="minimum depth of the evaluated images", ge=0, le=60)
    contact: Annotated[str | float, BeforeValidator(check_contact)] = parameter(
        "no-slip",
        unit="1",
        meaning="contact law of the nominal unit: frictionless, no-slip or the coefficient of friction",
    )
    cells: int | None = parameter(
        None, unit="1", meaning="cells along a meridian; empty: an eighth more than in the training", ge=4, le=200
    )
    solver: Literal["palpate", "calculix"] = parameter("palpate", unit="", meaning="solver of the presses")
    calibration_presses: int = parameter(
        0, unit="1", meaning="calibration presses by which each unit is identified first; requires a twin", ge=0, le=5
    )
    inverted: int = parameter(
        0, unit="1", meaning="number of units, the last ones, whose skin is inverted in all presses", ge=0
    )
    robot_tilt_deg: float = parameter(
        RobotUncertainty.tilt_deg,
        unit="deg",
        meaning="standard deviation of the robot's tilts in calibration presses",
        gt=0,
        le=5,
    )
    robot_depth: float = parameter(
        RobotUncertainty.depth,
        unit="mm",
        meaning="standard deviation of the robot's depths in calibration presses",
        gt=0,
        le=5,
    )
    zero: bool = parameter(
        True, unit="", meaning="whether the zero of the depth is determined by a first press, which is not evaluated"
    )
    tolerance: ToleranceSpec = ToleranceSpec()
    render: RenderSpec = DEGRADED
    seed: int = parameter(0, unit="1", meaning="seed of units, directions and images", ge=0)

    @model_validator(mode="after")
    def _inverted_units_are_units(self) -> VirtualBenchSpec:
        if self.inverted > self.units:
            raise PydanticCustomError(
                "inverted-exceed-units",
                "inverted is {inverted}, more than the number of units, {units}.",
                {"inverted": self.inverted, "units": self.units},
            )
        if self.inverted and self.solver != "palpate":
            raise PydanticCustomError(
                "inverted-needs-own-solver",
                "inverted units need the solver palpate; solver is {solver}.",
                {"solver": self.solver},
            )
        return self

    @model_validator(mode="after")
    def _some_images_count(self) -> VirtualBenchSpec:
        if self.min_depth > self.depth:
            raise PydanticCustomError(
                "images-too-shallow",
                "no image is evaluated: depth is {depth} mm, less than min_depth, {minimum} mm.",
                {"depth": f"{self.depth:g}", "minimum": f"{self.min_depth:g}"},
            )
        return self


class SimulatedRobotSpec(Spec):
    """Simulated robot with errors of position, rotation, compliance and images."""

    position_sd_mm: float = parameter(
        0.1, unit="mm", meaning="standard deviation of the position, along each axis", ge=0, le=5
    )
    rotation_sd_deg: float = parameter(
        0.05, unit="deg", meaning="standard deviation of the rotation, about each axis", ge=0, le=5
    )
    backlash_mm: float = parameter(0.05, unit="mm", meaning="backlash along each axis", ge=0, le=5)
    backlash_deg: float = parameter(0.02, unit="deg", meaning="backlash about each axis", ge=0, le=5)
    compliance: float = parameter(0.02, unit="mm/N", meaning="compliance of the flange", ge=0, le=2)
    approach_mm: float = parameter(
        2.0, unit="mm", meaning="maximum error of the assumed wall position, both ways", ge=0, le=100
    )
    offset_deg: float = parameter(
        1.0,
        unit="deg",
        meaning="maximum rotation offset between sensor and tool, about each axis, both ways",
        ge=0,
        le=10,
    )
    dropout: float = parameter(0.01, unit="1", meaning="share of corrupted images", ge=0, le=1)


class WorkpieceSpec(Spec):
    """Compliance of a workpiece: motion and rotation are proportional to the force along the normal."""

    wall_compliance: float = parameter(
        0.0, unit="mm/N", meaning="motion of the wall along its normal, per force", ge=0, le=10
    )
    wall_tilt_compliance: float = parameter(0.0, unit="deg/N", meaning="rotation of the wall, per force", ge=0, le=5)
    clamping_force: float = parameter(
        0.0, unit="N", meaning="force of the tool on the wall after the alignment", ge=0, le=5000
    )

    @model_validator(mode="after")
    def _rotations_are_small(self) -> WorkpieceSpec:
        turn = self.wall_tilt_compliance * self.clamping_force
        if turn > 30.0:
            raise PydanticCustomError(
                "workpiece-turned",
                "wall_tilt_compliance times clamping_force is {turn}°; at most 30° are simulated.",
                {"turn": f"{turn:g}"},
            )
        return self
