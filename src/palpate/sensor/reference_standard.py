"""Reference standard of the angles in an acceptance test, its uncertainty, and the environment.

A sine plate with rollers at a distance L on a stack of gauge blocks of height h has the angle sin α = h / L, hence

    u²(α) = [u²(h) + 2 u²(flatness)] / (L cos α)² + [tan α u(L) / L]² + u²(seat).

The flatness is that of the surface plate and of the sine plate over L; the seat is the tilt of the sensor's base
relative to the surface plate. An error δ of the direction of the slope relative to the axes of the sensor has no
effect on the total angle and changes rx and ry by up to α δ. All limits are half-widths of uniform distributions.
"""

from __future__ import annotations

import numpy as np
from pydantic import ConfigDict

from palpate.core import FloatArray, Spec, parameter
from palpate.core.state import State

_ASSUMED = "assumed; give the value of its certificate"
_BARREL = "assumed for a plastic barrel; drift of such cameras: Elias et al. 2020, doi 10.3390/s20030643"
_PDMS = "PDMS 247e-6: doi 10.1016/j.polymertesting.2020.106670"
_ENTROPY = "entropic elasticity, modulus proportional to temperature: 1/293 K"
_SD = 3.0**-0.5
"""Standard deviation of a uniform distribution over its half-width."""


class ReferenceSpec(Spec):
    """Reference standard of the angles, and environment of the test."""

    model_config = ConfigDict(str_strip_whitespace=True)

    reference: str = parameter("", unit="", meaning="reference standard, with its serial and certificate number")
    roller_distance: float = parameter(
        100.0, unit="mm", meaning="distance of the sine plate's rollers", gt=0, le=1000
    )
    roller_limit: float = parameter(0.003, unit="mm", meaning="limit of its error", source=_ASSUMED, ge=0, le=1)
    block_limit: float = parameter(0.001, unit="mm", meaning="error of the gauge blocks", source=_ASSUMED, ge=0, le=1)
    flatness_limit: float = parameter(0.002, unit="mm", meaning="flatness of a plate", source=_ASSUMED, ge=0, le=1)
    seat_limit_deg: float = parameter(0.01, unit="deg", meaning="tilt of the base", source=_ASSUMED, ge=0, le=5)
    direction_limit_deg: float = parameter(
        0.1, unit="deg", meaning="error of the slope's direction", source=_ASSUMED, ge=0, le=30
    )
    reference_tilt_deg: float = parameter(
        0.0, unit="deg", meaning="standard uncertainty of another reference, such as a robot; 0: plate", ge=0, le=5
    )
    reference_depth: float = parameter(
        0.02, unit="mm", meaning="standard uncertainty of the reference's depth", source=_ASSUMED, ge=0, le=5
    )
    temperature_c: float | None = parameter(
        None, unit="°C", meaning="temperature of the test; empty: not stated", flag="temperature", ge=-50, le=150
    )
    temperature_change: float = parameter(
        2.0, unit="K", meaning="half-width of the temperature's change since the rest image", ge=0, le=50
    )
    focal_per_k: float = parameter(
        1e-4, unit="1/K", meaning="change of the camera's image distance", source=_BARREL, ge=0, le=0.01
    )
    holder_per_k: float = parameter(
        7e-5, unit="1/K", meaning="expansion of the camera's holder", source="PLA: data sheets 68e-6", ge=0, le=0.01
    )
    skin_per_k: float = parameter(2.5e-4, unit="1/K", meaning="expansion of the skin", source=_PDMS, ge=0, le=0.01)
    modulus_per_k: float = parameter(
        0.0034, unit="1/K", meaning="change of the skin's modulus; no effect on angles", source=_ENTROPY, ge=0, le=0.1
    )

    @property
    def thermal(self) -> State:
        """Influence of temperature, as for `palpate.calibration.UncertaintyBudget.of_unit`."""
        names = ("focal_per_k", "holder_per_k", "skin_per_k", "modulus_per_k")
        values = {name: float(getattr(self, name)) for name in names}
        return State.from_mapping({"change_k": self.temperature_change} | values)

    def tilt_sd_deg(self, tilt_deg: float) -> FloatArray:
        """Return the standard uncertainties (2,) degrees of one axis and of the total angle, at a tilt."""
        tilt, length = np.radians(tilt_deg), self.roller_distance
        height = np.hypot(self.block_limit, np.sqrt(2.0) * self.flatness_limit) / (length * np.cos(tilt))
        parts = np.degrees([height, np.tan(tilt) * self.roller_limit / length]).tolist()
        total = self.reference_tilt_deg or _SD * float(np.linalg.norm([*parts, self.seat_limit_deg]))
        return np.array([np.hypot(total, _SD * tilt_deg * np.radians(self.direction_limit_deg)), total])

    def describe(self, tilt_deg: float) -> str:
        """Describe the standard and its uncertainty up to a tilt (degrees)."""
        axis, total = self.tilt_sd_deg(tilt_deg)
        name = self.reference or "Not stated; its uncertainty is assumed"
        kind = (
            f"standard uncertainty of the angle {self.reference_tilt_deg:g}°"
            if self.reference_tilt_deg
            else f"sine plate L = {self.roller_distance:g} ± {self.roller_limit:g} mm, blocks ± {self.block_limit:g} "
            f"mm, flatness ± {self.flatness_limit:g} mm, seat ± {self.seat_limit_deg:g}°"
        )
        return (
            f"{name}: {kind}; direction ± {self.direction_limit_deg:g}°; depth {self.reference_depth:g} mm. At "
            f"{tilt_deg:.1f}°: U = {2.0 * total:.3f}° of the total angle, {2.0 * axis:.3f}° of rx and ry (k = 2)."
        )
