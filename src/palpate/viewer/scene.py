"""Messages that draw one design: the surface once, then motion and markers for each pose."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate.camera import Camera
from palpate.core import FloatArray
from palpate.design import MarkerLayout, Skin
from palpate.viewer.library import RenderedSkin
from palpate.viewer.message import write_message
from palpate.viewer.pressed_skin import NODAL_FIELDS, SurfaceMotion, VisibleMarkers

_EDGE = 97
"""Points of an edge; the first and the last coincide."""


def describe_shell(specimen: RenderedSkin, layout: MarkerLayout, camera: Camera) -> bytes:
    """Message of the constant parts: rest (v, 3) mm, triangles, cells, seam (v,), markers, skin, camera.

    The triangles are ordered by parts, see `palpate.viewer.shell.PARTS`; clamps (c, r, 3) mm are the outer edges of
    the clamped parts.
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
        "turned": pressed.turned,
        "tilts_deg": pressed.tilts_deg.tolist(),
        "depth_mm": float(pressed.depths_mm[-1]),
        "marker_diameter_mm": layout.diameter,
        "width_px": camera.width_px,
        "height_px": camera.height_px,
    }
    arrays = {
        "rest": pressed.mesh.nodes[shell.nodes],
        "triangles": shell.triangles,
        "cells": shell.cells,
        "seam": shell.seam,
        "clamps": _clamps(skin),
        "rest_px": camera.project(layout.positions),
    }
    return write_message(meta, {**arrays, "rest_px": np.nan_to_num(arrays["rest_px"], nan=-1e4)})


def describe_motion(specimen: RenderedSkin, motion: SurfaceMotion, field: str = "") -> bytes:
    """The press at one pose: displacement (k, v, 3) mm and, if asked for, one of `NODAL_FIELDS` (k, v).

    Of a skin of revolution in the tilt frame, for all azimuths.
    """
    nodes = specimen.shell.nodes
    arrays = {"displacement": motion.displacement[:, nodes]}
    if field in NODAL_FIELDS:
        arrays[field] = specimen.pressed.nodal_field(motion, field)[:, nodes]
    return write_message(_motion_sentence(motion), arrays)


def describe_markers(seen: VisibleMarkers) -> bytes:
    """Message of the markers at one pose: positions (k, m, 3) mm, pixels (k, m, 2), radius, visibility."""
    return write_message(
        {},
        {
            "positions": seen.positions,
            "pixels": np.nan_to_num(seen.pixels, nan=-1e4),
            "radius": seen.radius_px,
            "seen": seen.seen,
        },
    )


def _clamps(skin: Skin) -> FloatArray:
    """Outer edges (c, r, 3) mm of the base, and of the far end where the skin is open there."""
    angle = np.linspace(0.0, 2 * np.pi, _EDGE)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.stack([skin.point(size * circle, 1.0) for size in ([1.0, skin.hole] if skin.hole else [1.0])])


def _motion_sentence(motion: SurfaceMotion) -> dict[str, Any]:
    return {
        "tilt_deg": motion.tilt_deg,
        "depths_mm": motion.depths_mm.tolist(),
        "force_n": motion.force_n.tolist(),
        "branch": list(motion.branch),
        "ended": motion.ended,
        "normal": motion.normal.tolist(),
        "touch_mm": motion.touch.tolist(),
        "way": motion.way.tolist(),
    }
