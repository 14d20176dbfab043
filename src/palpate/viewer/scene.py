"""What the page draws of one design, as messages: the shell once, then motion and markers for each pose."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from palpate.camera import Camera
from palpate.design import MarkerLayout, wall_normal
from palpate.viewer.library import Specimen
from palpate.viewer.markers_seen import MarkersSeen
from palpate.viewer.message import write_message
from palpate.viewer.pressed_dome import SurfaceMotion


def describe_shell(specimen: Specimen, layout: MarkerLayout, camera: Camera) -> bytes:
    """What does not change with the pose: rest (v, 3) mm, triangles (k, 3), seam (v,), dots at rest; dome and camera.

    The triangles lie part after part, see `palpate.viewer.shell.PARTS`.
    """
    pressed, shell = specimen.pressed, specimen.shell
    skin = pressed.mesh.skin
    meta = {
        "parts": {name: list(place) for name, place in shell.parts.items()},
        "height_mm": skin.height,
        "base_radius_mm": skin.base_radius,
        "thickness_mm": skin.thickness,
        "outer_radius_mm": skin.outer_widest[0],
        "outer_base_radius_mm": skin.outer_base_radius,
        "tilts_deg": pressed.tilts_deg.tolist(),
        "depth_mm": float(pressed.depths_mm[-1]),
        "marker_diameter_mm": layout.diameter,
        "width_px": camera.width_px,
        "height_px": camera.height_px,
    }
    arrays = {
        "rest": pressed.mesh.nodes[shell.nodes],
        "triangles": shell.triangles,
        "seam": shell.seam,
        "rest_px": camera.project(layout.positions),
    }
    return write_message(meta, {**arrays, "rest_px": np.nan_to_num(arrays["rest_px"], nan=-1e4)})


def describe_motion(specimen: Specimen, motion: SurfaceMotion, *, stress: bool = False) -> bytes:
    """The press at one tilt: displacement (k, v, 3) mm in the tilt frame and, if asked for, stress (k, v) MPa."""
    nodes = specimen.shell.nodes
    arrays = {"displacement": motion.displacement[:, nodes]}
    if stress:
        arrays["stress"] = specimen.pressed.stress(motion)[:, nodes]
    return write_message(_say_motion(specimen, motion), arrays)


def describe_markers(seen: MarkersSeen) -> bytes:
    """Markers at one pose: positions (k, m, 3) mm in the dome's frame, pixels (k, m, 2), radius, and who is seen."""
    return write_message(
        {},
        {
            "positions": seen.positions,
            "pixels": np.nan_to_num(seen.pixels, nan=-1e4),
            "radius": seen.radius_px,
            "seen": seen.seen,
        },
    )


def _say_motion(specimen: Specimen, motion: SurfaceMotion) -> dict[str, Any]:
    normal = wall_normal(math.radians(motion.tilt_deg), 0.0)
    touch = specimen.pressed.mesh.skin.touch(normal)
    return {
        "tilt_deg": motion.tilt_deg,
        "depths_mm": motion.depths_mm.tolist(),
        "force_n": motion.force_n.tolist(),
        "branch": list(motion.branch),
        "ended": motion.ended,
        "normal": normal.tolist(),
        "touch_mm": touch.tolist(),
    }
