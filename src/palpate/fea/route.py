"""A flat wall on a route through waypoints in six degrees of freedom: press, slide, twist and tilt.

The wall has the tilt of its first waypoint at first contact. The contact point is its pivot: it moves by the depth
along the skin's axis and laterally in the wall's plane, and the wall rotates about it. Between waypoints all six
numbers vary linearly with the length of the route, in which a rotation counts as the motion of a point at distance
`ARM`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, final

import numpy as np
from pydantic import BeforeValidator, model_validator
from pydantic_core import PydanticCustomError

from palpate.core import FloatArray, PalpateError, parameter
from palpate.design import OFFSET_SPACE, PoseSpace
from palpate.fea.spec import SAME_MM, ObstacleSpec
from palpate.fea.wall import Plane, refuse_rim_first
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

ARM = 20.0
"""Distance in mm by which a rotation is converted to a length. By hand."""


class Waypoint(NamedTuple):
    """Pose of a wall.

    Attributes
    ----------
    depth_mm, x_mm, y_mm
        Motion of its pivot along the skin's axis, and in the wall's plane along x and y, which tilt with it but do
        not twist.
    rx_deg, ry_deg, twist_deg
        Its rotation vector across the skin's axis, and its rotation about its own normal.
    """

    depth_mm: float = 0.0
    x_mm: float = 0.0
    y_mm: float = 0.0
    rx_deg: float = 0.0
    ry_deg: float = 0.0
    twist_deg: float = 0.0


_MOST = Waypoint(60.0, 30.0, 30.0, 30.0, 30.0, 90.0)


def _read(value: Any) -> Any:
    """Read waypoints from text, ``4 0 0 0 5; 4 2 0 0 5``: omitted numbers are 0."""
    if isinstance(value, str):
        value = [point.split() for point in value.split(";") if point.strip()]
    if not isinstance(value, list | tuple):
        return value
    try:
        return tuple(Waypoint(*map(float, point)) for point in value)
    except (TypeError, ValueError):
        raise PydanticCustomError(
            "waypoints-malformed",
            "each waypoint must be a list of up to six numbers, {names}: [[4, 0, 0, 0, 5], [4, 2]]",
            {"names": ", ".join(Waypoint._fields)},
        ) from None


@final
class RouteSpec(ObstacleSpec):
    """A rigid flat wall that moves through waypoints."""

    kind: Literal["route"] = "route"
    waypoints: Annotated[tuple[Waypoint, ...], BeforeValidator(_read)] = parameter(
        (Waypoint(4.0), Waypoint(4.0, 1.0)),
        unit="mm, deg",
        meaning="poses of the wall after first contact: depth, x, y in its own plane, rx, ry, twist",
    )
    depth: float = parameter(5.0, unit="mm", meaning="length of the route; follows from its waypoints", gt=0, le=1000)

    @model_validator(mode="before")
    @classmethod
    def _depth_is_the_length(cls, values: Any) -> Any:
        if not isinstance(values, dict):
            return values
        points = _read(values.get("waypoints", cls.model_fields["waypoints"].default))
        if not isinstance(points, tuple):
            return values
        if not points:
            raise PydanticCustomError("waypoints-none", "a route needs at least 1 waypoint", {})
        _check(points)
        return {**values, "waypoints": points, "depth": float(_lengths(points)[-1])}

    @property
    def label(self) -> str:
        return f"route of {len(self.waypoints)} waypoints"

    @property
    def mirrored(self) -> bool:
        return False

    @property
    def moves_laterally(self) -> bool:
        return True

    @property
    def stop_depths(self) -> tuple[float, ...]:
        return tuple(float(length) for length in _lengths(self.waypoints)[1:])

    @property
    def pose_space(self) -> PoseSpace:
        return OFFSET_SPACE

    @property
    def radial(self) -> float:
        return float(np.hypot(self.waypoints[0].rx_deg, self.waypoints[0].ry_deg))

    @property
    def turn_deg(self) -> float:
        return 0.0

    def waypoint(self, length: float) -> Waypoint:
        """Return the pose of the wall after a length in mm of its route."""
        at, points = _lengths(self.waypoints), np.array(_whole(self.waypoints))
        return Waypoint(*(float(np.interp(length, at, points[:, k])) for k in range(len(_MOST))))

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        refuse_rim_first(mesh, self.radial)
        normal = _turned(self.waypoint(0.0)).as_matrix()[:, 2]
        touched = mesh.skin.support_point(normal)
        return Plane(normal, touched), touched

    def path(self, mesh: Mesh) -> Callable[[float], Obstacle]:
        """Return the wall after a length in mm of its route.

        Raises
        ------
        PalpateError
            If the wall reaches the clamped rim at a waypoint.
        """
        path = partial(self._at, self.at_first_contact(mesh)[1])
        for number, (point, length) in enumerate(zip(self.waypoints, self.stop_depths, strict=True), start=1):
            tilt_deg, plane = float(np.hypot(point.rx_deg, point.ry_deg)), path(length)
            refuse_rim_first(mesh, tilt_deg)
            # depth below first contact of a wall of this tilt: the tilt may have changed along the route
            deep = float((mesh.skin.support_point(plane.normal) - plane.point) @ plane.normal / plane.normal[2])
            most = mesh.skin.clamp_depth(np.radians(tilt_deg), mesh.spec.rim)
            if deep > most:
                raise PalpateError(
                    f"At waypoint {number} the wall is {deep:.3g} mm deep; at its tilt of {tilt_deg:.3g}° it reaches "
                    f"the clamped rim at {most:.3g} mm.",
                    "Reduce the depth or the tilt.",
                    code="route-reaches-rim",
                )
        return path

    def _at(self, touched: FloatArray, length: float) -> Plane:
        """Return the wall after a length in mm, with its pivot at `touched` (3,) mm at first contact."""
        point = self.waypoint(length)
        axes, first = _turned(point).as_matrix(), _turned(self.waypoint(0.0)).as_matrix()
        tilted = _turned(point._replace(twist_deg=0.0)).as_matrix()
        pivot = touched + tilted @ [point.x_mm, point.y_mm, 0.0] - [0.0, 0.0, point.depth_mm]
        return Plane(axes[:, 2], pivot, axes @ first.T)


def _whole(points: tuple[Waypoint, ...]) -> tuple[Waypoint, ...]:
    """Return the waypoints with one before the first: at first contact, with its tilt."""
    return (Waypoint(rx_deg=points[0].rx_deg, ry_deg=points[0].ry_deg), *points)


def _turned(point: Waypoint) -> Rotation:
    """Return the rotation of the wall: its twist about the skin's axis, then its tilt."""
    from scipy.spatial.transform import Rotation  # here: its import takes half a second

    tilt = Rotation.from_rotvec([point.rx_deg, point.ry_deg, 0.0], degrees=True)
    return tilt * Rotation.from_rotvec([0.0, 0.0, point.twist_deg], degrees=True)


def _lengths(points: tuple[Waypoint, ...]) -> FloatArray:
    """Return the length (n + 1,) mm of the route at its start and at every waypoint."""
    steps = []
    for a, b in pairwise(_whole(points)):
        turn = np.radians(np.subtract(b[3:], a[3:]))
        steps.append(float(np.hypot(np.linalg.norm(np.subtract(b[:3], a[:3])), ARM * np.linalg.norm(turn))))
    return np.concatenate([[0.0], np.cumsum(steps)])


def _check(points: tuple[Waypoint, ...]) -> None:
    """Raise if a number is out of bounds or two successive waypoints are equal."""
    for number, point in enumerate(points, start=1):
        for name, value, most in zip(Waypoint._fields, point, _MOST, strict=True):
            least = 0.0 if name == "depth_mm" else -most
            if not least <= value <= most:
                raise PydanticCustomError(
                    "waypoint-out-of-bounds",
                    "waypoint {number} has {name} = {value}; choose a value from {minimum} to {maximum}",
                    {"number": number, "name": name, "value": f"{value:g}", "minimum": least, "maximum": most},
                )
    short = np.flatnonzero(np.diff(_lengths(points)) < SAME_MM)
    if len(short):
        raise PydanticCustomError(
            "waypoint-twice",
            "waypoint {number} is equal to the one before; leave it out",
            {"number": int(short[0]) + 1},
        )
