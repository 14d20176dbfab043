"""Export of the view at one pose: marker table and 3-D model."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError
from palpate.design import rotation_vector, turn_about_axis
from palpate.fea import Plane
from palpate.viewer.charts import VIRIDIS
from palpate.viewer.gltf import Part
from palpate.viewer.library import RenderedSkin
from palpate.viewer.pressed_skin import SurfaceMotion
from palpate.viewer.results import GridDesign


def marker_rows(
    design: GridDesign, specimen: RenderedSkin, tilt_deg: float, azimuth_deg: float
) -> list[dict[str, Any]]:
    """Return one row a depth and marker: pose (degrees, mm), position (mm), pixel, and visibility."""
    motion = specimen.pressed.at(tilt_deg, azimuth_deg)
    seen = specimen.pressed.markers(design.design.layout, design.design.camera, motion, azimuth_deg)
    rx, ry = rotation_vector(tilt_deg, np.radians(azimuth_deg))
    rows = []
    for k, depth in enumerate(motion.depths_mm):
        for marker in range(len(design.design.layout)):
            x, y, z = (f"{value:.5f}" for value in seen.positions[k, marker])
            u, v = (f"{value:.4f}" for value in seen.pixels[k, marker])
            pose = {"rx_deg": f"{rx:.6g}", "ry_deg": f"{ry:.6g}", "depth_mm": f"{depth:.6g}"}
            place = {"x_mm": x, "y_mm": y, "z_mm": z, "u_px": u, "v_px": v}
            rows.append({**pose, "marker": marker, **place, "seen": int(seen.seen[k, marker])})
    return rows


def dome_parts(design: GridDesign, specimen: RenderedSkin, pose: tuple[float, float, float]) -> list[Part]:
    """Return skin, markers and wall at a pose (depth mm, tilt and azimuth in degrees), skin's frame.

    Raises
    ------
    PalpateError
        If the depth is not reached at this tilt.
    """
    depth, tilt_deg, azimuth_deg = pose
    motion = specimen.pressed.at(tilt_deg, azimuth_deg)
    if not 0 <= depth <= motion.depths_mm[-1] + 1e-6:
        raise PalpateError(
            f"{depth:g} mm is not reached at {tilt_deg:g}°.",
            f"It ends at {motion.depths_mm[-1]:g} mm.",
            code="depth-not-reached",
        )
    turn = turn_about_axis(np.radians(azimuth_deg - motion.azimuth_deg))
    shell, nodes = specimen.shell, specimen.pressed.nodes
    moved = _between(motion, motion.displacement, depth)
    triangles = shell.triangles
    seen = shell.nodes[: triangles.max() + 1]
    points, size = (nodes + moved)[seen], np.linalg.norm(moved[seen], axis=1)
    if not specimen.pressed.mesh.spec.whole:
        triangles = np.concatenate([triangles, triangles[:, ::-1] + len(points)])
        points, size = np.concatenate([points, points * [-1.0, 1.0, 1.0]]), np.tile(size, 2)
    colours = _colours(size / max(float(np.abs(motion.displacement).max()), 1e-9))
    return [
        Part("dome", points @ turn.T, triangles, colours),
        _markers(design, specimen, motion, pose),
        _wall(specimen, motion, depth, turn),
    ]


def _between(motion: SurfaceMotion, field: NDArray[Any], depth: float) -> FloatArray:
    """Interpolate a field (k, …) linearly at a depth between its increments."""
    place = float(np.interp(depth, motion.depths_mm, np.arange(len(motion.depths_mm))))
    low = min(int(place), len(motion.depths_mm) - 1)
    high = min(low + 1, len(motion.depths_mm) - 1)
    mixed: FloatArray = field[low] + (place - low) * (np.asarray(field[high], float) - field[low])
    return mixed


def _markers(
    design: GridDesign, specimen: RenderedSkin, motion: SurfaceMotion, pose: tuple[float, float, float]
) -> Part:
    """Return each marker as an octahedron of the marker's width."""
    centres = _between(motion, specimen.pressed.positions(design.design.layout, motion, pose[2]), pose[0])
    corners = np.concatenate([np.eye(3), -np.eye(3)]) * design.design.layout.diameter / 2
    faces = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    points = (centres[:, None] + corners).reshape(-1, 3)
    triangles = (faces[None] + 6 * np.arange(len(centres))[:, None, None]).reshape(-1, 3)
    return Part("markers", points, triangles, np.tile([0.1, 0.1, 0.12, 1.0], (len(points), 1)))


def _wall(specimen: RenderedSkin, motion: SurfaceMotion, depth: float, turn: FloatArray) -> Part:
    at = motion.touch - depth * motion.way
    points, _ = Plane(motion.normal, at).patch(at, 1.2 * specimen.pressed.mesh.skin.outer_widest[0])
    return Part("wall", points @ turn.T, np.array([[0, 1, 2], [0, 2, 3]]), np.tile([0.6, 0.65, 0.7, 0.5], (4, 1)))


def _colours(share: FloatArray) -> FloatArray:
    """Colours (v, 4) of shares (v,) from 0 to 1."""
    steps = np.array([[int(code[i : i + 2], 16) / 255 for i in (1, 3, 5)] for code in VIRIDIS])
    at = np.linspace(0, 1, len(steps))
    mixed = np.stack([np.interp(share, at, steps[:, i]) for i in range(3)], axis=-1)
    return np.concatenate([mixed, np.ones((len(share), 1))], axis=1)
