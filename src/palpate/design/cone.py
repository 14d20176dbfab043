"""Cone with a round or a flat tip; a steep one is a finger, a cylinder with a round end."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal, Self, final

import numpy as np

from palpate.core import FloatArray, PalpateError, parameter
from palpate.design.outline import Arc, Outline
from palpate.design.revolved import RevolvedSkin, plain_numbers
from palpate.design.spec import TaperedSpec


@final
class ConeSpec(TaperedSpec):
    """Cone with a round tip, or with a flat tip and a rounded edge.

    If the edge radius is the base radius, without a flat, it is a cylinder with a hemispherical end.
    """

    kind: Literal["cone"] = "cone"
    flat_radius: float = parameter(0.0, unit="mm", meaning="radius of the flat at the tip", ge=0, le=60)
    edge_radius: float = parameter(
        8.0, unit="mm", meaning="radius of curvature from the flat, or the apex, to the flank", gt=0, le=500
    )

    def build(self) -> Cone:
        sizes = (self.height, self.base_radius, self.thickness)
        made = Cone(*sizes, self.flat_radius, self.edge_radius, self.taper)
        if made.edge_to_rim < self.edge_radius:
            raise PalpateError(
                f"An edge of radius {self.edge_radius:g} mm extends beyond the rim, which is only "
                f"{made.edge_to_rim:.4g} mm from its centre.",
                "Use a smaller edge radius, or a larger base.",
                code="cone-edge-outside-rim",
            )
        return made


@final
@dataclass(frozen=True)
class Cone(RevolvedSkin):
    """A flat, an arc and a straight flank that meet smoothly, parametrised by their length.

    The distance from the arc's centre (f, H - e) to the rim is ``D = √((B - f)² + (H - e)²)``, at an angle
    ``δ = atan((H - e)/(B - f))`` below the horizontal. The flank is tangent to the arc where the normal is inclined
    by ``θ = δ + asin(e / D)``, and is ``√(D² - e²)`` long. f is `flat_radius`, e `edge_radius`; for the further
    dimensions see `RevolvedSkin`.
    """

    height: float
    base_radius: float
    thickness: float
    flat_radius: float
    edge_radius: float
    taper: float = 1.0

    @property
    def name(self) -> str:
        flat = f"{self.flat_radius:g}+" if self.flat_radius else ""
        return f"cone {flat}{self.edge_radius:g} {super().name}"

    @property
    def shape(self) -> str:
        if self.flat_radius:
            return f"cone with a flat of radius {self.flat_radius:g} mm and an edge of {self.edge_radius:g} mm"
        return f"cone with a tip of radius {self.edge_radius:g} mm"

    @property
    def spec_data(self) -> dict[str, Any]:
        return plain_numbers("cone", asdict(self))

    @property
    def edge_to_rim(self) -> float:
        """Distance from the centre of the edge to the rim, mm."""
        return float(np.hypot(self.base_radius - self.flat_radius, self.height - self.edge_radius))

    @property
    def flank_slope(self) -> float:
        """Angle in rad between the axis and the flank's normal."""
        below = np.arctan2(self.height - self.edge_radius, self.base_radius - self.flat_radius)
        return float(below + np.arcsin(min(self.edge_radius / self.edge_to_rim, 1.0)))

    @cached_property
    def _ends(self) -> tuple[float, float, float]:
        """Length in mm along the meridian to the ends of flat, arc and flank."""
        arc = self.flat_radius + self.edge_radius * self.flank_slope
        return self.flat_radius, arc, arc + float(np.sqrt(max(self.edge_to_rim**2 - self.edge_radius**2, 0.0)))

    @property
    def breaks(self) -> tuple[float, float]:
        """Parameters of the meridian at the ends of flat and arc."""
        flat, arc, whole = self._ends
        return flat / whole, arc / whole

    @property
    def radius(self) -> float:
        return self.edge_radius

    def scaled(self, factor: float) -> Self:
        sizes = (factor * self.height, factor * self.base_radius, factor * self.thickness)
        return type(self)(*sizes, factor * self.flat_radius, factor * self.edge_radius, self.taper)

    def curve(self, t: FloatArray, order: int = 0) -> FloatArray:
        flat, arc, whole = self._ends
        length, edge = whole * t, self.edge_radius
        angle = np.clip((length - flat) / edge, 0.0, self.flank_slope)
        across, down = np.sin(angle), np.cos(angle)
        straight = np.where(length > arc, length - arc, np.minimum(length, flat) - flat)
        if order == 0:
            x = flat + edge * across + straight * down
            return np.column_stack([x, self.height - edge * (1 - down) - straight * across])
        if order == 1:
            return whole * np.column_stack([down, -across])
        bent = ((length >= flat) & (length <= arc))[:, None] / edge
        return np.asarray(whole**2 * bent * np.column_stack([-across, -down]))

    def meridian(self, offset: float, *, down: bool) -> Outline:
        """See `Skin`: for an even skin, lines and an arc that the CAD kernel represents exactly."""
        edge, theta = self.edge_radius + offset, self.flank_slope
        foot = float(self.base_radius + offset / np.sin(theta))
        if (self.taper != 1.0 and offset > 0) or edge <= 0:
            return super().meridian(offset, down=down)
        flat = (self.flat_radius, self.height + offset)
        half, end = (
            (float(flat[0] + edge * np.sin(angle)), float(flat[1] - edge * (1 - np.cos(angle))))
            for angle in (theta / 2, theta)
        )
        if end[1] <= 0:
            return super().meridian(offset, down=down)
        apex = (0.0, flat[1])
        if down:
            return [*([flat] if flat[0] else []), Arc(half, end), (foot, 0.0)]
        return [end, Arc(half, flat), *([apex] if flat[0] else [])]
