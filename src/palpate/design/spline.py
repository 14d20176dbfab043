"""Skin whose meridian is a spline through points: any smooth shape of revolution."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any, Literal, Self, final

import numpy as np
from pydantic import field_validator
from pydantic_core import PydanticCustomError

from palpate.core import FloatArray, PalpateError, parameter
from palpate.design.revolved import RevolvedSkin, plain_numbers
from palpate.design.spec import TaperedSpec

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_SAMPLES = 400
"""Points along the meridian at which radius and shape are checked. By hand."""
_FLAT = 0.01
"""Ratio of height to radius of curvature at the apex below which it counts as flat. By hand."""
_TIGHTEST = 0.9
"""Maximum ratio of skin thickness to a concave radius of curvature; above 1 the outer surface folds.
By hand."""


@final
class SplineSpec(TaperedSpec):
    """Skin whose meridian is a cubic spline from the apex through points to the rim."""

    kind: Literal["spline"] = "spline"
    points: tuple[tuple[float, float], ...] = parameter(
        ((0.5, 0.866),),
        unit="1",
        meaning="points of the meridian between apex and rim: distance from the axis and height, over base radius "
        "and height",
    )

    @field_validator("points", mode="before")
    @classmethod
    def _points_are_pairs(cls, points: Any) -> Any:
        if isinstance(points, str):
            raise PydanticCustomError(
                "points-as-words",
                "'{points}' are not pairs of numbers; write the skin into a study: points: [[0.5, 0.9], [0.85, 0.5]]",
                {"points": points},
            )
        return points

    @field_validator("points")
    @classmethod
    def _points_stand_over_the_base(cls, points: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        for rho, z in points:
            if not (0 < rho <= 3 and 0 < z <= 1.5):
                raise PydanticCustomError(
                    "point-not-over-base",
                    "the point ({rho}, {z}) is not within 0 to 3 base radii of the axis and 0 to 1.5 heights",
                    {"rho": f"{rho:g}", "z": f"{z:g}"},
                )
        return points

    def build(self) -> Spline:
        made = Spline(self.height, self.base_radius, self.thickness, self.points, self.taper)
        made.refuse()
        return made


@final
@dataclass(frozen=True)
class Spline(RevolvedSkin):
    """Cubic spline over the length of its chords, level at the apex, not-a-knot at the rim.

    `points` are (rho, z) between apex and rim, over base radius and height; for the further dimensions see
    `RevolvedSkin`.
    """

    height: float
    base_radius: float
    thickness: float
    points: tuple[tuple[float, float], ...]
    taper: float = 1.0

    @property
    def name(self) -> str:
        return f"spline {' '.join(f'{x:g}' for x in chain(*self.points))} {super().name}"

    @property
    def shape(self) -> str:
        count = len(self.points)
        return f"skin of revolution through {count} point{'s' if count > 1 else ''} of its meridian"

    @property
    def spec_data(self) -> dict[str, Any]:
        return plain_numbers("spline", asdict(self) | {"points": [list(point) for point in self.points]})

    @property
    def radius(self) -> float:
        """See `Skin`: ``1 / -κ`` at the apex, or the minimum of the meridian if the apex is flat or concave."""
        round_ = -self._hollow(np.linspace(0.0, 1.0, _SAMPLES))
        return float(1.0 / (round_[0] if round_[0] * self.height > _FLAT else round_.max()))

    def scaled(self, factor: float) -> Self:
        sizes = (factor * self.height, factor * self.base_radius, factor * self.thickness)
        return type(self)(*sizes, self.points, self.taper)

    @cached_property
    def _splines(self) -> tuple[CubicSpline, CubicSpline]:
        from scipy.interpolate import CubicSpline

        between = np.array(self.points).reshape(-1, 2) * [self.base_radius, self.height]
        knots = np.vstack([[0.0, self.height], between, [self.base_radius, 0.0]])
        chords = np.linalg.norm(np.diff(knots, axis=0), axis=1)
        t = np.concatenate([[0.0], np.cumsum(chords)]) / chords.sum()
        bent, level, free = (2, 0.0), (1, 0.0), "not-a-knot"
        return CubicSpline(t, knots[:, 0], bc_type=(bent, free)), CubicSpline(t, knots[:, 1], bc_type=(level, free))

    def curve(self, t: FloatArray, order: int = 0) -> FloatArray:
        inside = np.minimum(t, 1.0)
        found = np.column_stack([each(inside, order) for each in self._splines])
        beyond = (t - inside)[:, None]
        if order == 0:
            return np.asarray(found + beyond * np.column_stack([each(inside, 1) for each in self._splines]))
        return np.asarray(np.where((beyond > 0) & (order > 1), 0.0, found))

    def refuse(self) -> None:
        """Reject a meridian that crosses the axis or the base, or is too concave for the skin thickness.

        Raises
        ------
        PalpateError
            If it does.
        """
        t = np.linspace(0.0, 1.0, _SAMPLES)
        curve, hollow = self.curve(t), self._hollow(t)
        if curve[1:, 0].min() <= 0 or curve[:-1, 1].min() <= 0:
            raise PalpateError(
                f"The meridian of {self.name} crosses the axis or the base between its points.",
                "Use more points, or points at a greater distance from them.",
                code="meridian-crosses-axis",
            )
        fill = float((hollow * self.wall_thickness(t)).max())
        if fill > _TIGHTEST:
            raise PalpateError(
                f"The meridian is concave with a radius of {1 / hollow.max():.3g} mm, and the skin thickness is "
                f"{self.thickness:g} mm: the outer surface would fold.",
                "Use a thinner skin, or points of a less curved meridian.",
                code="meridian-too-hollow",
            )
