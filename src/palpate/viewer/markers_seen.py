"""Markers of a pressed dome: where they are, and where the camera sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.camera import Camera
from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.design import MarkerLayout, turn_about_axis
from palpate.mesh import Mesh, locate_inner
from palpate.viewer.pressed_dome import Motion


@dataclass(frozen=True, eq=False)
class MarkersSeen:
    """Markers at one pose of the wall, at every depth.

    Attributes
    ----------
    positions
        (k, m, 3) mm, dome's frame.
    pixels
        (k, m, 2) px; NaN for one behind the camera.
    radius_px
        (k, m) about how large the dot looks.
    seen
        (k, m) whether the camera sees it.
    """

    positions: FloatArray
    pixels: FloatArray
    radius_px: FloatArray
    seen: BoolArray


def follow_markers(
    mesh: Mesh, motion: Motion, layout: MarkerLayout, camera: Camera, azimuth_deg: float
) -> MarkersSeen:
    """Follow markers through a press whose wall is turned to an azimuth.

    Parameters
    ----------
    mesh, motion
        A pressed half dome, in its tilt frame.
    layout
        Undeformed markers, dome's frame.
    camera
        Who looks.
    azimuth_deg
        Direction of the wall's rotation axis: (rx, ry) = tilt (cos, sin).

    Raises
    ------
    PalpateError
        If the azimuth is not finite, or a marker is not on the dome.
    """
    positions = follow_points(mesh, motion, layout.positions, azimuth_deg)
    dome = mesh.dome
    seen = camera.visible(positions, dome)
    reach = np.linalg.norm(positions - camera.origin, axis=-1)
    radius = camera.spec.fx_px * layout.diameter / 2.0 / np.maximum(reach, 1e-3)
    return MarkersSeen(positions, camera.project(positions), radius, seen)


def follow_points(mesh: Mesh, motion: Motion, points: FloatArray, azimuth_deg: float) -> FloatArray:
    """Deformed positions (k, m, 3) mm of undeformed points (m, 3) of the inner surface, dome's frame."""
    if not np.isfinite(azimuth_deg):
        raise PalpateError(f"The azimuth {azimuth_deg} is no angle.", "Give degrees.")
    turn = turn_about_axis(np.radians(azimuth_deg))  # dome_from_tilt
    local = points @ turn
    side = np.where(local[:, :1] < 0, [[-1.0, 1.0, 1.0]], 1.0)
    moved = locate_inner(mesh, local * side).interpolate(motion.displacement.astype(float)) * side
    positions: FloatArray = points + moved @ turn.T
    return positions
