"""Markers of a pressed dome: where they are, and where the camera sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.camera import Camera
from palpate.core import BoolArray, FloatArray
from palpate.design import MarkerLayout
from palpate.viewer.pressed_skin import PressedSkin, SurfaceMotion


@dataclass(frozen=True, eq=False)
class VisibleMarkers:
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
    pressed: PressedSkin, motion: SurfaceMotion, layout: MarkerLayout, camera: Camera, azimuth_deg: float
) -> VisibleMarkers:
    """Follow markers through a press whose wall is turned to an azimuth.

    Parameters
    ----------
    pressed, motion
        A pressed skin, and its press at one pose.
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
    positions = pressed.markers(layout, motion, azimuth_deg)
    seen = camera.visible(positions, pressed.mesh.skin)
    reach = np.linalg.norm(positions - camera.origin, axis=-1)
    radius = camera.spec.fx_px * layout.diameter / 2.0 / np.maximum(reach, 1e-3)
    return VisibleMarkers(positions, camera.project(positions), radius, seen)
