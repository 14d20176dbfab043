"""Flat pad of gel on a window, as in tactile cameras: a rectangle with rounded corners and edges.

          ____________          z = H + T, flat
        .'            '.
       /                \\       flanks over a rounded edge
      /__________________\\      z = 0: the rim is a superellipse of half width B along x and k B along y

It is a cone with a flat whose distance from the axis is replaced by the pseudo-radius of its plan, a
`palpate.design.superellipse`. With the meridian (ρ, z)(t) of the cone and the edge w(φ) of the plan, its surfaces are

    x(t, φ) = (ρ(t) w(φ), z(t))

It is flat, at the height of the design, where the cone is. At its flanks and edges the skin is stretched with the
plan, and thicker: at the corners by the ratio of their distance to the half width.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Literal, Self, final

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray, PalpateError, parameter
from palpate.design.cone import Cone, ConeSpec
from palpate.design.outline import Outline
from palpate.design.ray import trace_rays
from palpate.design.revolved import BEYOND
from palpate.design.skin import Rim, Skin, Symmetry
from palpate.design.spec import SkinSpec
from palpate.design.superellipse import Superellipse

_NEWTON = 20
"""Maximum number of Newton steps to the nearest point. By hand."""
_SINGULAR = 1e-12
"""Minimum determinant of a Newton matrix over the square of its trace; below, no step is made."""
_GAUSS = np.polynomial.legendre.leggauss(16)


@final
class FlatPadSpec(SkinSpec):
    """Flat pad, a rectangle with rounded corners; `base_radius` is half its width along x at the rim."""

    kind: Literal["pad"] = "pad"
    stretch: float = parameter(1.2, unit="1", meaning="length along y over width along x", ge=1, le=2.5)
    squareness: float = parameter(
        6.0,
        unit="1",
        meaning="exponent of the plan: 2 an ellipse, 4 to 8 a rectangle with round corners",
        ge=2,
        le=10,
    )
    flat_radius: float = parameter(8.0, unit="mm", meaning="half width along x of the flat on top", gt=0, le=60)
    edge_radius: float = parameter(
        2.0, unit="mm", meaning="radius of curvature from the flat to the flank, in the plane y = 0", gt=0, le=60
    )

    def build(self) -> FlatPad:
        section = ConeSpec(
            height=self.height,
            base_radius=self.base_radius,
            thickness=self.thickness,
            flat_radius=self.flat_radius,
            edge_radius=self.edge_radius,
        ).build()
        if section.bulges or self.flat_radius >= self.base_radius:
            raise PalpateError(
                f"A flat of half width {self.flat_radius:g} mm with an edge of {self.edge_radius:g} mm overhangs a "
                f"base of half width {self.base_radius:g} mm.",
                "Use a smaller flat or edge, or a larger base.",
                code="pad-overhangs",
            )
        return FlatPad(**self.model_dump(exclude={"kind"}))


@final
@dataclass(frozen=True)
class FlatPad(Skin):
    """Geometry of a flat pad.

    Attributes
    ----------
    height, base_radius, thickness
        Height of the marked flat over the base, half width of the rim along x, skin thickness at the flat, mm.
    stretch, squareness
        k and n of the plan.
    flat_radius, edge_radius
        Dimensions of the section along x, see `Cone`, mm; along y they are k times as long.
    """

    height: float
    base_radius: float
    thickness: float
    stretch: float
    squareness: float
    flat_radius: float
    edge_radius: float

    @cached_property
    def cone(self) -> Cone:
        """Section along x, as a body of revolution."""
        return Cone(self.height, self.base_radius, self.thickness, self.flat_radius, self.edge_radius)

    @cached_property
    def plan(self) -> Superellipse:
        """Plan, for a half width of 1."""
        return Superellipse(self.stretch, self.squareness)

    @property
    def name(self) -> str:
        edge = f"{self.flat_radius:g}+{self.edge_radius:g}"
        return f"pad {edge} x{self.stretch:g} n{self.squareness:g} {super().name}"

    @property
    def shape(self) -> str:
        wide, long = 2 * self.base_radius, 2 * self.stretch * self.base_radius
        return f"flat pad of {wide:.4g} mm by {long:.4g} mm with an edge of {self.edge_radius:g} mm"

    @property
    def spec_data(self) -> dict[str, Any]:
        return {"kind": "pad", **asdict(self)}

    @property
    def symmetry(self) -> Symmetry:
        return Symmetry.MIRRORED

    @property
    def radius(self) -> float:
        return self.edge_radius

    @property
    def widest(self) -> tuple[float, float]:
        return self.plan.farthest * self.base_radius, 0.0

    @property
    def outer_widest(self) -> tuple[float, float]:
        return self.plan.farthest * self.outer_base_radius, 0.0

    @property
    def bulges(self) -> bool:
        return False

    @property
    def rim_thickness(self) -> float:
        """See `Skin`: the maximum, at the corners."""
        return self.plan.farthest * self.thickness

    def reach(self, azimuth: ArrayLike) -> FloatArray:
        way = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
        return np.asarray(self.base_radius / self.plan.pseudo_radius(way))

    def scaled(self, factor: float) -> Self:
        lengths = ("height", "base_radius", "thickness", "flat_radius", "edge_radius")
        return replace(self, **{name: factor * getattr(self, name) for name in lengths})

    def point(self, disc: FloatArray, layer: float, rim: Rim = Rim.FLAT) -> FloatArray:
        round_one = self.cone.point(disc, layer, rim)
        edge = self.plan.edge(np.arctan2(disc[:, 1], disc[:, 0]))[0]
        return np.column_stack([np.hypot(round_one[:, 0], round_one[:, 1])[:, None] * edge, round_one[:, 2]])

    def _round(self, points: FloatArray) -> FloatArray:
        """Map points (n, 3) from the pad to its cone."""
        return np.column_stack([self.plan.level(points[:, :2]), points[:, 2]])

    def disc(self, points: FloatArray) -> FloatArray:
        return self.cone.disc(self._round(points))

    def inner_point(self, rho: ArrayLike, azimuth: ArrayLike) -> FloatArray:
        rho, azimuth = np.broadcast_arrays(np.asarray(rho, float), np.asarray(azimuth, float))
        place = np.stack([rho * np.cos(azimuth), rho * np.sin(azimuth)], axis=-1)
        height = self.cone.inner_point(self.plan.pseudo_radius(place), 0.0)[..., 2]
        return np.concatenate([place, height[..., None]], axis=-1)

    def _surface(self, t: FloatArray, angle: FloatArray) -> FloatArray:
        """Return points (n, 3) mm of the inner surface at parameters and angles of the disc (n,)."""
        curve = self.cone.curve(t)
        return np.column_stack([curve[:, :1] * self.plan.edge(angle)[0], curve[:, 1]])

    def _foot(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the disc's parameter and angle (n,) of the inner surface's nearest point (Newton's method)."""
        start = self.cone.disc(self._round(points))
        t, angle = np.hypot(start[:, 0], start[:, 1]), np.arctan2(start[:, 1], start[:, 0])
        for _ in range(_NEWTON):
            step = self._step(points, t, angle)
            if np.abs(step).max(initial=0.0) < 1e-14:
                break
            t, angle = np.clip(t + step[:, 0], 0.0, BEYOND), angle + step[:, 1]
        return t, angle

    def _step(self, points: FloatArray, t: FloatArray, angle: FloatArray) -> FloatArray:
        """Return the Newton step (n, 2) of parameter and angle, without curvature terms if that is an ascent."""
        (rho, z), (by_rho, by_z), (bend_rho, bend_z) = (self.cone.curve(t, order).T for order in range(3))
        edge, turn, bend = self.plan.edge(angle)
        gap, height = points[:, :2] - rho[:, None] * edge, points[:, 2] - z
        along, across, out = ((gap * way).sum(axis=1) for way in (edge, turn, bend))
        push = np.column_stack([by_rho * along + by_z * height, rho * across])
        first = by_rho**2 * (edge**2).sum(axis=1) + by_z**2
        mixed, second = rho * by_rho * (edge * turn).sum(axis=1), rho**2 * (turn**2).sum(axis=1)
        own = _matrix(first - bend_rho * along - bend_z * height, mixed - by_rho * across, second - rho * out)
        uphill = (np.linalg.det(own) <= 0) | (own[:, 0, 0] <= 0)
        own[uphill] = _matrix(first, mixed, second)[uphill]
        flat = np.linalg.det(own) < _SINGULAR * np.trace(own, axis1=1, axis2=2) ** 2
        own[flat] = np.eye(2)
        push[flat] = 0.0
        return np.asarray(np.linalg.solve(own, push[..., None])[..., 0])

    def _normals(self, t: FloatArray, angle: FloatArray) -> FloatArray:
        """Return outward unit normals (n, 3): those of the meridian, along the gradient of the pseudo-radius."""
        slope = self.cone.curve(t, 1)
        way = -slope[:, 1:] * self.plan.gradient(self.plan.edge(angle)[0])
        normal = np.column_stack([way, slope[:, 0]])
        return np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None])

    def normal(self, points: FloatArray) -> FloatArray:
        points = np.asarray(points, float)
        return self._normals(*self._foot(points.reshape(-1, 3))).reshape(points.shape)

    def nearest(self, points: FloatArray) -> FloatArray:
        points = np.asarray(points, float)
        return self._surface(*self._foot(points.reshape(-1, 3))).reshape(points.shape)

    def distance(self, points: ArrayLike) -> FloatArray:
        points = np.asarray(points, float)
        flat = points.reshape(-1, 3)
        foot = self._foot(flat)
        gap = ((flat - self._surface(*foot)) * self._normals(*foot)).sum(axis=1)
        return np.asarray(gap.reshape(points.shape[:-1]))

    def _gap(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the distance (n,) of mapped points (n, 3) from the cone, and its gradient, at most 1 long."""
        far, slope = self.cone.gap(self._round(points))
        lean = np.hypot(slope[:, 0], slope[:, 1])[:, None] * self.plan.gradient(points[:, :2])
        return far, np.column_stack([lean, slope[:, 2]])

    def hit(self, origin: FloatArray, rays: FloatArray) -> FloatArray:
        return trace_rays(self._gap, lambda at: self.plan.pseudo_radius(at[:, :2]) <= self.base_radius, origin, rays)

    def distance_to_rim(self, points: ArrayLike) -> FloatArray:
        points = np.asarray(points, float)
        t, scale = self._along(points.reshape(-1, 3))
        left = self._length(np.ones_like(t), scale) - self._length(t, scale)
        return np.asarray(left.reshape(points.shape[:-1]))

    def arc_length(self, points: FloatArray) -> FloatArray:
        """See `Skin`: in the vertical plane through axis and point."""
        return self._length(*self._along(points))

    def at_arc_length(self, length: FloatArray) -> FloatArray:
        """See `Skin`: along x."""
        return self.cone.at_arc_length(length)

    def _along(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the parameter (n,) of points (n, 3), and the horizontal scale (n,) of their meridian."""
        disc = self.disc(points)
        edge = self.plan.edge(np.arctan2(disc[:, 1], disc[:, 0]))[0]
        return np.hypot(disc[:, 0], disc[:, 1]), np.linalg.norm(edge, axis=1)

    def _length(self, t: FloatArray, scale: FloatArray) -> FloatArray:
        """Return the length (n,) mm from the apex to parameters (n,) of meridians of a horizontal scale (n,)."""
        flat, arc = np.minimum(np.array(self.cone.breaks)[:, None], t)
        total = scale * self.cone.curve(flat)[:, 0]
        for low, high in ((flat, arc), (arc, t)):
            half = (high - low) / 2
            for at, weight in zip(*_GAUSS, strict=True):
                slope = self.cone.curve(low + half * (1 + at), 1)
                total = total + weight * half * np.hypot(scale * slope[:, 0], slope[:, 1])
        return np.asarray(total)

    def support_point(self, normal: FloatArray) -> FloatArray:
        way = np.array([float(self.plan.support(normal[:2])), 0.0, normal[2]])
        place = self.cone.support_point(way)
        return np.array([*(place[0] * self.plan.support_point(normal[:2])), place[2]])

    def support_height(self, normals: FloatArray) -> FloatArray:
        """See `Skin`: on the edge, ``f s + H - e + (e + T) √(1 + s²)`` with the wall's slope s over its plan."""
        slope = self.plan.support(normals[:, :2]) / normals[:, 2]
        edge = self.edge_radius + self.thickness
        return np.asarray(self.flat_radius * slope + self.height - self.edge_radius + edge * np.hypot(1.0, slope))

    @property
    def inner_slope(self) -> float:
        """See `Skin`: the maximum, in the middle of the sides along y."""
        return self.cone.inner_slope

    def rim_slope(self, rim: Rim) -> float:
        """See `Skin`: the minimum, at the corners."""
        slope = self.cone.rim_slope(rim)
        return float(np.arctan2(np.sin(slope), self.plan.farthest * np.cos(slope)))

    def clamp_depth(self, tilt: float, rim: Rim) -> float:
        """See `Skin`: at the azimuth with the minimum."""
        lean = np.arctan(self.plan.farthest * np.tan(tilt))
        return self.cone.clamp_depth(float(lean), rim)

    def meridian(self, offset: float, *, down: bool) -> Outline:
        """See `Skin`: the section along x."""
        return self.cone.meridian(offset, down=down)


def _matrix(first: FloatArray, mixed: FloatArray, second: FloatArray) -> FloatArray:
    """Return symmetric matrices (n, 2, 2)."""
    return np.stack([np.stack([first, mixed], axis=-1), np.stack([mixed, second], axis=-1)], axis=-2)
