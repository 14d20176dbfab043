"""Thin sphere between two plates: flat contact, and the inverted cap (Updike & Kalnins 1970).

The upper half of the shell, an eighth of it by symmetry, is pressed by one plate. Reference: a geometrically exact
axisymmetric shell code, forces in ``E h³/R``, energies in ``E h⁴/R``, R the mean radius. The inverted branch starts
from the shell mirrored at the plate, and is followed from large depth back to its end.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.core import FloatArray
from palpate.material import Material, NeoHooke
from palpate.mechanics import Increment
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import Grid, Turn, even, join, revolve
from palpate.verify.pressing import Pressing
from palpate.verify.read_reference import Reference, read_reference
from validation import REFERENCE
from validation.graded import graded

RADIUS = 100.0
"""Mean radius, mm."""
_PENALTY, _WIDTH = 120.0, 1e-3
"""Contact stiffness over E/h and width of its start over h, as in a press of a dome. By hand."""


_POISSON = (0.3, 0.5)
"""Poisson's ratios of the shells."""
RATIOS = (20.0, 50.0, 100.0)
"""R/h of the shells."""
_TOLERANCE, _THICK = 2e-2, 20.0
"""Tolerance of forces, and R/h up to which h/R is added, the error of thin shells (Koiter 1960)."""
_ONSET, _EXACT = 0.1, 0.02
"""Tolerance of the onset depth of the inverted cap, over h; last increments of unloading, over h/2.
By hand."""
_DRAWN_BACK, _ITERATIONS = 3.0, 20
"""Displacement over h from which the plate is retracted; Newton steps of an increment at most.
By hand."""
_CELLS = {"flat": 40, "dimple": 110}
"""Cells from pole to equator: the ring of an inverted cap is narrower than a flat patch. By hand."""
_TRAVEL = {"flat": [0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "dimple": [4.0, 5.0, 6.0]}
"""Displacements of the plate over the thickness at which forces are compared. By hand."""


def make_shell(thickness: float, cells: int) -> Grid:
    """Mesh an eighth of a sphere with `cells` from pole to equator, half of them in the pressed part."""

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
    material = Material("shell", NeoHooke(0.5), bulk_ratio=bulk_ratio)
    grid = make_shell(thickness, cells)
    fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
    top = RADIUS + thickness / 2
    outside = np.abs(np.linalg.norm(grid.nodes, axis=1) - top) < 1e-6 * RADIUS
    solid = make_solid(grid, material, fixed)
    penalty = _PENALTY * material.young_modulus / thickness
    contact = (penalty, _WIDTH * thickness)
    return Pressing(solid, grid.outer_cells(outside), top, contact, 1e-6 * thickness**2, thickness)


def against_shell(branch: str, ratio: float) -> list[Row]:
    """Force on the flat or the inverted (``dimple``) branch of a shell of R/h = `ratio`."""
    tolerance = _TOLERANCE + (1 / ratio if ratio <= _THICK else 0.0)
    return [
        compare(f"F R / (E h³), nu = {poisson}", force, expected, tolerance, _labels(branch))
        for poisson, (force, expected) in _solve(branch, ratio).items()
    ]


def dimple_onset(ratio: float) -> list[Row]:
    """Compare the onset depth of the inverted cap over the thickness, found by retracting the plate."""
    rows: list[Row] = []
    shape: FloatArray | None = None
    for poisson in _POISSON:
        data = read_reference("sphere_shell_plate_compression", REFERENCE).where(**_name(ratio, poisson, "dimple"))
        pressing = make_pressing(ratio, poisson, _CELLS["dimple"])
        depth = _DRAWN_BACK * pressing.size
        path = pressing.relax(depth, _mirrored(pressing, depth) if shape is None else shape)
        shape = path.last.state.u
        steps = {"first_step": 0.4, "largest_step": 0.4, "smallest_step": _EXACT, "iterations": _ITERATIONS}
        path.spec = path.spec.model_copy(update=steps)
        path.restart()
        path.advance(0.0)
        expected = data["delta_over_h"].min()
        onset = path.last.depth / pressing.size
        rows.append(compare(f"inverted from d/h, nu = {poisson}", onset, expected, _ONSET, scale=1.0))
    return rows


def thin_limit(branch: str) -> list[Row]:
    """Compare the ratio to a shell without thickness, extrapolated to h/R = 0 by three shells."""
    rows = []
    for poisson in _POISSON:
        shares = [np.divide(*_solve(branch, ratio)[poisson]) for ratio in RATIOS]
        limit = np.polyfit(1 / np.array(RATIOS), np.array(shares), 1)[1]
        title = f"ratio carried to h/R = 0, nu = {poisson}"
        rows.append(compare(title, limit, np.ones(len(limit)), _TOLERANCE, _labels(branch)))
    return rows


def _labels(branch: str) -> list[str]:
    return [f"d/h = {value:g}" for value in _TRAVEL[branch]]


@cache
def _solve(branch: str, ratio: float) -> dict[float, tuple[FloatArray, FloatArray]]:
    """Forces over ``E h³ / R``, palpate's and the reference's, by Poisson's ratio; 0.5 may start from 0.3."""
    solve = {"flat": _follow_flat, "dimple": _relax_inverted}[branch]
    shapes: list[FloatArray] = []
    forces = {}
    for poisson in _POISSON:
        data = _reference(ratio, poisson, branch)
        pressing = make_pressing(ratio, poisson, _CELLS[branch])
        found = solve(pressing, data["delta_over_h"] * RADIUS / ratio, shapes)
        shapes = [item.state.u for item in found]
        unit = pressing.solid.material.young_modulus * pressing.size**3 / RADIUS
        forces[poisson] = np.array([4 * item.loads.force[2] for item in found]) / unit, data["FR_over_Eh3"]
    return forces


def _follow_flat(pressing: Pressing, depths: FloatArray, _: list[FloatArray]) -> list[Increment]:
    return pressing.follow(list(depths), stabilised=True)


def _relax_inverted(pressing: Pressing, depths: FloatArray, shapes: list[FloatArray]) -> list[Increment]:
    """Relax from the shapes of another material, or from the mirrored cap."""
    starts = shapes or [_mirrored(pressing, depth) for depth in depths]
    return [pressing.relax(depth, shape).last for depth, shape in zip(depths, starts, strict=True)]


def _reference(ratio: float, poisson: float, branch: str) -> Reference:
    data = read_reference("sphere_shell_plate_compression", REFERENCE).where(**_name(ratio, poisson, branch))
    return data.at("delta_over_h", _TRAVEL[branch])


def _name(ratio: float, poisson: float, branch: str) -> dict[str, str]:
    return {"R_over_h": f"{ratio:.1f}", "nu": f"{poisson}", "branch": branch}


def _mirrored(pressing: Pressing, depth: float) -> FloatArray:
    """Displacement (n, 3) mm that mirrors the cap above the plate at a depth, with a rounded ridge."""
    nodes = pressing.solid.nodes
    radius, across = np.linalg.norm(nodes, axis=1), np.hypot(nodes[:, 0], nodes[:, 1])
    outward = np.divide(nodes[:, :2], across[:, None], out=np.zeros((len(nodes), 2)), where=across[:, None] > 0)
    offset, sin, cos = radius - RADIUS, across / radius, nodes[:, 2] / radius
    above = RADIUS * cos - (RADIUS - depth)
    rounded = np.sqrt(above**2 + pressing.size**2)
    slope = RADIUS * sin * above / rounded
    length = np.hypot(RADIUS * cos, slope)
    r = RADIUS * sin - offset * slope / length
    z = RADIUS - depth - rounded + offset * RADIUS * cos / length
    moved = np.column_stack([r[:, None] * outward, z]) - nodes
    return np.where(pressing.solid.fixed, 0.0, moved)
