"""Pose spaces: names, units, bounds and errors of the components that a sensor estimates.

Networks, intervals, readings, tables, grids and the metadata of models use these declarations.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from palpate.core import FloatArray, PalpateError
from palpate.design.line_pose import LONGEST_DEG, direction_vector, line_error, offset_and_angle
from palpate.design.pose import rotation_vector


class PoseComponent(NamedTuple):
    """One component of a pose.

    Attributes
    ----------
    axis, unit
        Short name, e.g. ``rx``, and ``deg`` or ``mm``.
    label
        Name in the paper's tables, e.g. ``roll``.
    bounds
        Minimum and maximum that an obstacle's spec allows.
    """

    axis: str
    unit: str
    label: str
    bounds: tuple[float, float]

    @property
    def name(self) -> str:
        """Column name, e.g. ``rx_deg``."""
        return f"{self.axis}_{self.unit}"

    @property
    def unit_symbol(self) -> str:
        """Unit for display after a number: ``°`` or `` mm``."""
        return "°" if self.unit == "deg" else f" {self.unit}"


@dataclass(frozen=True)
class PoseSpace:
    """Ordered components of a pose; the first two are Cartesian parts of one polar quantity.

    Attributes
    ----------
    components
        First the two that rotate with the azimuth, then the depth.
    polar
        Name of the length of the first two, e.g. ``angle``.
    turn_deg
        Rotation of a half model's frame (`palpate.fea.ObstacleSpec.turn_deg`) at azimuth 0 of the pose.
    is_line
        Whether the obstacle is a line, whose direction is in the last two components (`palpate.design.line_pose`).
    is_side
        Whether it presses a skin's side; the poses then fill an annulus about the straight one instead of a disc.
    """

    components: tuple[PoseComponent, ...]
    polar: str
    turn_deg: float
    is_line: bool = False
    is_side: bool = False

    @staticmethod
    def from_names(names: Sequence[str]) -> PoseSpace:
        """Return the space whose components have the names of a file; unknown ones have no bounds.

        Raises
        ------
        PalpateError
            If there are fewer than three, or a name does not consist of axis and unit.
        """
        for space in (TILT_SPACE, OFFSET_SPACE, _LINE_DEPTH):
            if space.names == tuple(names):
                return space
        parts = [name.rpartition("_") for name in names]
        if len(parts) < 3 or not all(axis and unit for axis, _, unit in parts):
            raise PalpateError(
                f"Unknown pose components {', '.join(names)}.",
                "Make the file again.",
                code="pose-components-unknown",
            )
        return PoseSpace.from_axes([(axis, unit) for axis, _, unit in parts])

    @staticmethod
    def for_lines() -> PoseSpace:
        """Return the space of level bars and edges: position, depth, and doubled direction."""
        return _LINE_DEPTH

    @staticmethod
    def for_side_walls() -> PoseSpace:
        """Return the space of walls at a skin's side: components of any wall, for rotations of about 90°."""
        return _SIDE_DEPTH

    @staticmethod
    def from_axes(parts: Sequence[tuple[str, str]]) -> PoseSpace:
        """Return a space of any components, each an axis and a unit, without bounds.

        Examples
        --------
        >>> PoseSpace.from_axes([("angle", "deg")]).names
        ('angle_deg',)
        """
        anything = (float("-inf"), float("inf"))
        components = tuple(PoseComponent(axis, unit, axis, anything) for axis, unit in parts)
        return PoseSpace(components, OFFSET_SPACE.polar, OFFSET_SPACE.turn_deg)

    @property
    def is_tilt(self) -> bool:
        """Whether the first two components are those of a wall's rotation vector."""
        return self.polar == TILT_SPACE.polar

    @property
    def names(self) -> tuple[str, ...]:
        """Column names: ``rx_deg, ry_deg, depth_mm``."""
        return tuple(component.name for component in self.components)

    @property
    def half_width_names(self) -> tuple[str, ...]:
        """Column names of the interval half-widths: ``rx_half_width_deg`` …"""
        return tuple(f"{component.axis}_half_width_{component.unit}" for component in self.components)

    @property
    def errors(self) -> tuple[tuple[str, tuple[int, ...], str], ...]:
        """Evaluated errors: name, columns of the poses, unit; the polar quantity first."""
        joint = (self.polar, (0, 1), self.components[0].unit)
        return (joint, *((item.axis, (k,), item.unit) for k, item in enumerate(self.components)))

    def fits(self, axes: Iterable[str]) -> bool:
        """Return whether these are the axes of its errors."""
        return {name for name, _, _ in self.errors} == set(axes)

    def cartesian(self, radial: float, turn_deg: float) -> FloatArray:
        """Return the first two components (2,) of an obstacle from its `radial` and its `turn_deg`."""
        return rotation_vector(radial, np.radians(turn_deg - self.turn_deg))

    def poses(self, parts: FloatArray, depths: FloatArray) -> FloatArray:
        """Return poses (n, k) of first two components (n, 2) and depths (n,) mm; lines are normal to (x, y)."""
        poses = np.column_stack([parts, depths])
        if not self.is_line:
            return poses
        azimuth = np.degrees(np.arctan2(parts[:, 1], parts[:, 0]))
        return np.column_stack([poses, direction_vector(azimuth + self.turn_deg)])

    def pose(self, radial: float, turn_deg: float, depth: float) -> FloatArray:
        """Return the pose (k,) of an obstacle from its `radial`, its `turn_deg` and its depth in mm."""
        pose = np.append(self.cartesian(radial, turn_deg), depth)
        return np.append(pose, direction_vector(np.array(turn_deg))) if self.is_line else pose

    def line(self, poses: ArrayLike) -> FloatArray:
        """Return offset (mm) and angle (degrees) (..., 2) of line poses (..., 5) (`palpate.design.line_pose`).

        Raises
        ------
        PalpateError
            If the space is not that of lines.
        """
        self._refuse_no_line()
        return offset_and_angle(poses)

    def line_error(self, estimates: ArrayLike, poses: ArrayLike) -> FloatArray:
        """Return errors (..., 2) of lines in offset (mm) and angle (degrees); estimates and poses (..., 5).

        Raises
        ------
        PalpateError
            If the space is not that of lines.
        """
        self._refuse_no_line()
        return line_error(estimates, poses)

    def _refuse_no_line(self) -> None:
        if not self.is_line:
            raise PalpateError(
                f"{', '.join(self.names)} are not the pose of a line.",
                "Use presses of a bar or an edge.",
                code="pose-not-line",
            )

    def error(self, estimates: FloatArray, poses: FloatArray) -> FloatArray:
        """Return the length (n,) of the error of the first two components of poses (n, k), degrees or mm."""
        return np.asarray(np.hypot(*(np.asarray(estimates) - poses)[:, :2].T))


_DEPTH = PoseComponent("depth", "mm", "depth", (0.0, 60.0))
TILT_SPACE = PoseSpace(
    (
        PoseComponent("rx", "deg", "roll", (-30.0, 30.0)),
        PoseComponent("ry", "deg", "pitch", (-30.0, 30.0)),
        _DEPTH,
    ),
    "angle",
    turn_deg=0.0,
)
"""Flat wall: the components of its rotation vector, and its depth."""
OFFSET_SPACE = PoseSpace(
    (PoseComponent("x", "mm", "x", (-60.0, 60.0)), PoseComponent("y", "mm", "y", (-60.0, 60.0)), _DEPTH),
    "offset",
    turn_deg=-90.0,
)
"""Obstacle with an offset from the axis: its position, and its depth."""
_SIDE_DEPTH = PoseSpace(
    (
        PoseComponent("rx", "deg", "roll", (-120.0, 120.0)),
        PoseComponent("ry", "deg", "pitch", (-120.0, 120.0)),
        _DEPTH,
    ),
    TILT_SPACE.polar,
    TILT_SPACE.turn_deg,
    is_side=True,
)
"""Wall at the side; files name its components like those of any wall, and are read as such."""
_LINE_DEPTH = PoseSpace(
    (
        *OFFSET_SPACE.components,
        PoseComponent("cos2", "deg", "cos2", (-LONGEST_DEG, LONGEST_DEG)),
        PoseComponent("sin2", "deg", "sin2", (-LONGEST_DEG, LONGEST_DEG)),
    ),
    "offset",
    turn_deg=-90.0,
    is_line=True,
)
"""Level bar or edge: its point nearest to the axis, its depth, its direction."""
