"""Tolerances of built units: range of sampled deviations, and prior of a fit."""

from __future__ import annotations

import math

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from palpate.core import Spec, parameter

_SLIP_MEAN, _SLIP_SD = 1.0, 1.0
"""Prior of 1/µ: silicone on metal is near 1; 0 is no slip. By hand."""


class ToleranceSpec(Spec):
    """Tolerances of a built unit: half-widths of its deviations from the design.

    The defaults are those of a careful workshop: a mold of printed or turned parts measured by a caliper, a syringe
    and a scale for the two components, pad printing, and a camera on a printed holder, calibrated by a board.
    """

    thickness: float = parameter(0.05, unit="mm", meaning="skin thickness", ge=0, le=1)
    modulus: float = parameter(
        0.03,
        unit="1",
        meaning="relative deviation of the stiffness, equal for all constants of the law",
        ge=0,
        le=0.9,
    )
    stiffening: float = parameter(
        0.1,
        unit="1",
        meaning="relative deviation of the higher-order constants from the first constant of the law",
        ge=0,
        le=0.9,
    )
    friction_min: float = parameter(
        0.8,
        unit="1",
        meaning="minimum coefficient of friction on a clean wall; 0: as in the training",
        ge=0,
        le=5,
    )
    friction_max: float = parameter(
        0.0, unit="1", meaning="maximum coefficient of friction; 0: twice the minimum", ge=0, le=10
    )
    marker_position: float = parameter(
        0.1, unit="mm", meaning="position of each printed marker, in both directions", ge=0, le=2
    )
    print_shift: float = parameter(
        0.2, unit="mm", meaning="position of the whole print, in both directions", ge=0, le=5
    )
    missing: float = parameter(0.02, unit="1", meaning="share of missing markers", ge=0, le=0.4)
    camera_offset: float = parameter(
        0.5, unit="mm", meaning="offset of the camera from the axis, in both directions", ge=0, le=5
    )
    camera_distance: float = parameter(0.5, unit="mm", meaning="distance of the camera", ge=0, le=10)
    camera_tilt_deg: float = parameter(1.0, unit="deg", meaning="tilt of the camera about both axes", ge=0, le=10)
    camera_roll_deg: float = parameter(5.0, unit="deg", meaning="rotation of the camera about its axis", ge=0, le=180)
    focal: float = parameter(0.003, unit="1", meaning="relative error of the calibrated focal length", ge=0, le=0.2)
    centre_px: float = parameter(
        1.0, unit="px", meaning="error of the calibrated centre of the lens, in both directions", ge=0, le=50
    )
    distortion: float = parameter(
        0.01, unit="1", meaning="error of the calibrated first distortion coefficient", ge=0, le=0.5
    )
    seating_tilt_deg: float = parameter(
        0.1, unit="deg", meaning="tilt of the skin relative to the robot, about both axes", ge=0, le=5
    )
    seating_turn_deg: float = parameter(
        0.3, unit="deg", meaning="rotation of the skin about its axis relative to the robot", ge=0, le=30
    )
    depth_zero: float = parameter(
        1.0,
        unit="mm",
        meaning="error of the robot's depth at first contact",
        source="depth bias of Zaid et al. 2024, Table 3",
        ge=0,
        le=5,
    )
    lateral: float = parameter(
        0.0, unit="mm", meaning="lateral motion of the robot in a press, in both directions", ge=0, le=5
    )
    twist_deg: float = parameter(
        0.0, unit="deg", meaning="twist of the robot about the wall normal in a press", ge=0, le=10
    )

    curvature: float = parameter(0.0, unit="1/m", meaning="curvature of the walls, both ways; 0: flat", ge=0, le=20)

    def friction_at(self, share: float) -> float:
        """Return the coefficient of friction at a share (0 to 1) of its distribution.

        Uniform in µ up to twice the minimum; uniform in 1/µ, from maximum to minimum, if `friction_max` is given.
        """
        if not self.friction_max:
            return self.friction_min * (1.0 + share)
        return 1.0 / (share / self.friction_min + (1.0 - share) / self.friction_max)

    @model_validator(mode="after")
    def _least_is_least(self) -> ToleranceSpec:
        if self.friction_max and not 0 < self.friction_min <= self.friction_max:
            raise PydanticCustomError(
                "frictions-not-rising",
                "friction_min is {minimum} and friction_max {maximum}; friction_min must be positive and not larger.",
                {"minimum": f"{self.friction_min:g}", "maximum": f"{self.friction_max:g}"},
            )
        return self

    @property
    def inverse_friction_prior(self) -> tuple[float, float]:
        """Prior mean and standard deviation of 1/µ: that of silicone on metal, or from both limits."""
        if not self.friction_max:
            return _SLIP_MEAN, _SLIP_SD
        least, most = 1.0 / self.friction_max, 1.0 / self.friction_min
        return 0.5 * (least + most), max(_SLIP_SD, (most - least) / math.sqrt(12.0))

    @property
    def curvature_sd(self) -> float:
        """Standard deviation of a wall's curvature, 1/m."""
        return self.curvature / math.sqrt(3.0)

    @property
    def lateral_sd(self) -> tuple[float, float, float]:
        """Standard deviations of a press's lateral motion in x and y (mm) and of its twist (degrees)."""
        return self.lateral / math.sqrt(3.0), self.lateral / math.sqrt(3.0), self.twist_deg / math.sqrt(3.0)
