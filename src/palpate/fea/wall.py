"""Where the wall is: a plane turned by (rx, ry) that moves along the dome's axis from first touch."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import Dome
from palpate.fea.contact import Plane
from palpate.fea.spec import WallSpec
from palpate.mesh import Mesh, Rim, rim_angle


def wall_normal(rx: float, ry: float) -> FloatArray:
    """Outward normal (3,) of the wall for its rotation vector (rx, ry) in radians.

    ``n = cos(t) e_z + sin(t) (ry, -rx, 0) / t`` with ``t = |(rx, ry)|``: e_z turned by the rotation vector.
    """
    tilt = float(np.hypot(rx, ry))
    if tilt == 0.0:
        return np.array([0.0, 0.0, 1.0])
    return np.array([np.sin(tilt) * ry / tilt, -np.sin(tilt) * rx / tilt, np.cos(tilt)])


def normal_in_mesh(mesh: Mesh, wall: WallSpec) -> FloatArray:
    """Outward normal (3,) of the wall in the frame of the mesh: a half model lies in the tilt plane.

    Raises
    ------
    PalpateError
        If the wall touches the clamped rim before the dome.
    """
    tilt, azimuth = np.radians(wall.tilt_deg), np.radians(wall.azimuth_deg) if mesh.spec.whole else 0.0
    rim = rim_angle(mesh.dome, mesh.dome.outer_radius, mesh.spec.rim)
    if tilt >= rim:
        raise PalpateError(
            f"A wall tilted by {wall.tilt_deg:g}° touches the clamped rim (at {np.degrees(rim):.1f}° from the axis) "
            "before the dome.",
            "Tilt it less, or make the dome higher.",
        )
    return wall_normal(tilt * np.cos(azimuth), tilt * np.sin(azimuth))


def wall_at(dome: Dome, normal: FloatArray, depth: float) -> Plane:
    """Wall at a depth in mm; depth 0 is tangent to the outer sphere at the tilted touch point."""
    return Plane(normal=normal, point=touch_point(dome, normal) - np.array([0.0, 0.0, depth]))


def touch_point(dome: Dome, normal: FloatArray) -> FloatArray:
    """First point (3,) mm of the outer surface that a wall of this normal touches."""
    return np.array([0.0, 0.0, dome.center_z]) + dome.outer_radius * normal


def clamp_depth(dome: Dome, tilt: float, rim: Rim) -> float:
    """Depth in mm at which a wall of this tilt (rad) reaches the clamped outer rim.

    ``d = R (1 - cos(theta_rim - t)) / cos t`` with the polar angle theta_rim of the outer rim; infinite where the
    dome bulges so far that the wall would have to pass its widest circle first.
    """
    theta = rim_angle(dome, dome.outer_radius, rim)
    return float(dome.outer_radius * (1.0 - np.cos(theta - tilt)) / np.cos(tilt))
