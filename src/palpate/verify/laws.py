"""Laws that hold between presses: scaling with size, and the mirror."""

from __future__ import annotations

import numpy as np

from palpate.design import DomeSpec, build_skin
from palpate.fea import WallSpec, solve_press
from palpate.mesh import MeshSpec, mesh_skin
from palpate.verify.case import Row, below, compare
from palpate.verify.properties import SILICONE


def dome_scaling() -> list[Row]:
    """Compare a dome ten times as large: 100 times the force, 1000 times the energy."""
    small, large = (
        solve_press(
            mesh_skin(build_skin(DomeSpec(height=5 * k, base_radius=5 * k, thickness=0.5 * k)), MeshSpec(cells=10)),
            SILICONE,
            WallSpec(tilt_deg=5, depth=1.6 * k, depth_step=0.4 * k, contact="no-slip"),
        )
        for k in (1.0, 10.0)
    )
    at = [f"d/B = {depth / 5:g}" for depth in small.depth[1:]]
    moved = float(np.abs(large.displacement - 10 * small.displacement).max())
    return [
        compare("force of a dome ten times as large, N", large.force[1:, 2], 100 * small.force[1:, 2], 1e-6, at),
        compare("its energy, mJ", large.energy[1:], 1000 * small.energy[1:], 1e-6, at),
        below("its displacement, mm", moved, 1e-5),
        compare("its Newton iterations", float(large.newton_iterations), float(small.newton_iterations), 0.0),
    ]


def mirror() -> list[Row]:
    """A whole dome under two walls that are mirror images in x = 0: forces and displacements are, too."""
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=3)), MeshSpec(cells=10, whole=True))
    walls = [
        WallSpec(tilt_deg=6, azimuth_deg=azimuth, depth=2.4, contact="frictionless") for azimuth in (25.0, -25.0)
    ]
    one, other = (solve_press(mesh, SILICONE, wall) for wall in walls)
    side = np.array([-1.0, 1.0, 1.0])
    angle = np.radians([10.0, 100.0, 190.0, 280.0])
    points = np.column_stack([8 * np.cos(angle), 8 * np.sin(angle), np.full(4, np.sqrt(400.0 - 64.0))])
    moved = np.abs(one.positions(points)[-1] * side - other.positions(points * side)[-1]).max()
    miss = np.abs(one.force[-1] * side - other.force[-1]).max() / np.linalg.norm(one.force[-1])
    return [
        below("positions, mm", float(moved), 1e-8),
        below("force over its size", float(miss), 1e-8),
    ]
