"""A thin sphere between two plates: flat contact, and the cap turned inside out (Updike & Kalnins 1970).

The upper half of the shell, an eighth of it by symmetry, is pressed by one plate. Reference: a geometrically exact
axisymmetric shell code, forces in ``E h³/R``, energies in ``E h⁴/R``, R the mean radius. The inverted branch is
reached from the shell mirrored at the plate, and followed from deep back to where it ends.
"""

from __future__ import annotations

import numpy as np

from palpate.material import Material, neo_hooke
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import FloatArray, Grid, Turn, even, graded, join, revolve
from palpate.verify.pressing import Pressing
from palpate.verify.read_reference import read_reference

RADIUS = 100.0
"""Mean radius, mm."""
_PENALTY, _WIDTH = 120.0, 1e-3
"""Contact stiffness over E/h and width of its start over h, as in a press of a dome."""


def make_shell(thickness: float, cells: int) -> Grid:
    """Mesh an eighth of a sphere with `cells` from pole to equator, half of them in the part that is pressed."""

    def section(q: FloatArray) -> FloatArray:
        polar, r = 0.5 * np.pi * q[:, 0], RADIUS + thickness * (q[:, 1] - 0.5)
        return np.column_stack([r * np.sin(polar), r * np.cos(polar)])

    pressed = np.sqrt(2 * 7 * thickness / RADIUS) / (0.5 * np.pi)
    fine = int(0.7 * cells)
    return join(revolve(section, (graded(pressed / fine, fine, cells), even(1)), Turn(1), solid=True))


def make_pressing(ratio: float, poisson: float, cells: int) -> Pressing:
    """Press a shell of R/h = `ratio`."""
    thickness = RADIUS / ratio
    bulk_ratio = 2 * (1 + poisson) / (3 * (1 - 2 * poisson)) if poisson < 0.5 else 2000.0
    material = Material("shell", neo_hooke(0.5), bulk_ratio=bulk_ratio)
    grid = make_shell(thickness, cells)
    fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
    top = RADIUS + thickness / 2
    outside = np.abs(np.linalg.norm(grid.nodes, axis=1) - top) < 1e-6 * RADIUS
    solid = make_solid(grid, material, fixed)
    penalty = _PENALTY * material.young_modulus / thickness
    return Pressing(solid, grid.outer_cells(outside), top, penalty, _WIDTH * thickness, 1e-6 * thickness**2, thickness)


def mirrored(pressing: Pressing, thickness: float, depth: float) -> FloatArray:
    """Displacement (n, 3) mm that mirrors the cap above the plane, its ridge rounded; straight through the wall."""
    nodes = pressing.solid.nodes
    radius = np.linalg.norm(nodes, axis=1)
    offset, normal = radius - RADIUS, nodes / radius[:, None]
    azimuth = np.divide(nodes[:, :2], np.hypot(*nodes[:, :2].T)[:, None], out=np.zeros((len(nodes), 2)), where=normal[:, 2:] < 1 - 1e-15)
    sin, cos = np.hypot(normal[:, 0], normal[:, 1]), normal[:, 2]
    above = RADIUS * cos - (RADIUS - depth)
    rounded = np.sqrt(above**2 + thickness**2)
    z = RADIUS - depth - rounded
    slope = RADIUS * sin * above / rounded
    length = np.hypot(RADIUS * cos, slope)
    r = RADIUS * sin - offset * slope / length
    z = z + offset * RADIUS * cos / length
    return np.column_stack([r[:, None] * azimuth, z]) - nodes
