"""Solid sphere pressed by a plane, a ball and a bar: Hertz contact and large compression.

Between two frictionless plates the plane through the equator is one of symmetry: an eighth of the sphere is solved,
pressed by one plate. Hertz (Johnson, *Contact Mechanics*, 1985, chapter 4): ``F = 4/3 E* sqrt(R) d^1.5``,
``a² = R d``, ``p0 = 3 F / (2 pi a²)``, ``p² = p0² (1 - r²/a²)``; for small strain, d/R up to 0.005.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from palpate.core import FloatArray
from palpate.fea import Ball, Cylinder
from palpate.material import Material, NeoHooke
from palpate.mechanics import Obstacle
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import Grid, Turn, even, join, revolve
from palpate.verify.pressing import Pressing
from palpate.verify.read_reference import read_reference
from palpate.verify.rubber import MATERIALS, YEOH
from validation import REFERENCE
from validation.graded import graded

_CORE = 0.45
"""Half side of the square core of the section over the radius. By hand."""
_STIFF = 400.0
"""Penalty over E and the contact radius: penetration stays near two thousandths of the depth."""

_TENTHS = (0.2, 0.5, 1.0)
"""Displacement of the plate over a tenth of the radius. By hand."""


def make_ball(radius: float, along: FloatArray, below: FloatArray, up: int, turn: Turn) -> Grid:
    """Mesh an eighth of a sphere.

    Parameters
    ----------
    radius
        mm.
    along
        Cell boundaries 0…1 along the surface from the pole to 45°.
    below
        Cell boundaries 0…1 from the surface down to the core.
    up
        Cells from the equator up to the core's top.
    turn
        Cells around.
    """
    inward, rise = 1 - below[::-1], even(up)

    def core(q: FloatArray) -> FloatArray:
        return _CORE * radius * q

    def upper(q: FloatArray) -> FloatArray:
        angle = 0.25 * np.pi * q[:, 0]
        edge = _CORE * np.column_stack([q[:, 0], np.ones_like(angle)])
        return radius * _between(edge, np.column_stack([np.sin(angle), np.cos(angle)]), q[:, 1:])

    def side(q: FloatArray) -> FloatArray:
        angle = 0.25 * np.pi * (1 + q[:, 0])
        edge = _CORE * np.column_stack([np.ones_like(angle), 1 - q[:, 0]])
        return radius * _between(edge, np.column_stack([np.sin(angle), np.cos(angle)]), q[:, 1:])

    return join(
        revolve(core, (along, rise), turn, solid=True),
        revolve(upper, (along, inward), turn, solid=True),
        revolve(side, (1 - rise[::-1], inward), turn, solid=False),
    )


def _between(inner: FloatArray, outer: FloatArray, share: FloatArray) -> FloatArray:
    return (1 - share) * inner + share * outer


def make_pressing(
    grid: Grid, radius: float, material: Material, contact_radius: float, obstacle: Obstacle | None = None
) -> Pressing:
    """Press an eighth of a sphere of a radius (mm), with the penalty for a contact radius, mm; by a plate."""
    fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
    outside = np.abs(np.linalg.norm(grid.nodes, axis=1) - radius) < 1e-6 * radius
    penalty = _STIFF * material.young_modulus / contact_radius
    tolerance = 1e-6 * material.law.shear_modulus * contact_radius**2
    solid = make_solid(grid, material, fixed)
    contact = (penalty, 1e-5 * contact_radius)
    return Pressing(solid, grid.outer_cells(outside), obstacle or radius, contact, tolerance, contact_radius)


def make_fine_ball(radius: float, contact_radius: float) -> Grid:
    """Mesh an eighth of a sphere with cells of 0.15 times the contact radius (mm) under the contact."""
    cell = 0.15 * contact_radius / radius
    along, below = graded(cell / (0.25 * np.pi), 10, 17), graded(cell / (1 - _CORE), 3, 13)
    return make_ball(radius, along, below, 3, Turn(1))


def hertz() -> list[Row]:
    """Compare force, contact radius and maximum pressure at the largest and smallest d/R up to 0.005.

    Hertz's law is the limit of small a/R: a sphere between plates is stiffer by some 0.27 a/R, 1.9 % at d/R = 0.005.
    So the ratio to Hertz, extrapolated to a/R = 0, is compared as well.
    """
    data = read_reference("hertz_sphere_plane", REFERENCE)
    data = data.where(R_mm="10", approach_mm="0.05").joined(data.where(R_mm="22", approach_mm="0.05"))
    found = np.array([_press_lightly(*pose) for pose in zip(data["R_mm"], data["approach_mm"], strict=True)])
    force, reach, peak = found.T
    at = [f"R, d = {label} mm" for label in data.labels("R_mm", "approach_mm")]
    _, limit = np.polyfit(np.sqrt(data["approach_mm"] / data["R_mm"]), force / data["force_N"], 1)
    return [
        compare("force, N", force, data["force_N"], 2e-2, at),
        compare("radius of contact, mm", reach, data["contact_radius_mm"], 2e-2, at),
        compare("maximum pressure, MPa", peak, data["p0_MPa"], 2e-2, at),
        compare("force over Hertz's", limit, 1.0, 2e-2, ["a/R = 0"]),
    ]


def _press_lightly(radius: float, depth: float) -> tuple[float, float, float]:
    """Return force (N), contact radius (mm) and maximum pressure (MPa) for a radius and depth in mm.

    The contact radius follows from the pressure's second moment, ``a² = 5/2 ∫ p r² / F``; the maximum pressure from a
    line through the squared pressure over r².
    """
    reach = float(np.sqrt(radius * depth))
    pressing = make_pressing(make_fine_ball(radius, reach), radius, YEOH, reach)
    found = pressing.follow([depth])[0]
    inside = np.maximum(pressing.reach(found) - pressing.law.width / 2, 0.0)
    x = pressing.surface.interpolate(pressing.solid.nodes + found.state.u)
    square, pressure = x[:, 0] ** 2 + x[:, 1] ** 2, pressing.law.stiffness * inside
    force = pressing.surface.faces.weight.ravel() * pressure
    contact_radius = float(np.sqrt(2.5 * (force * square).sum() / force.sum()))
    middle = square < (0.7 * reach) ** 2
    _, peak = np.polyfit(square[middle], pressure[middle] ** 2, 1)
    return 4 * float(found.loads.force[2]), contact_radius, float(np.sqrt(peak))


def compression() -> list[Row]:
    """Compare force, energy and bulge of a sphere of radius 10 mm, compressed by up to 0.4 R a plate."""
    radius, rows = 10.0, []
    for name, material in MATERIALS.items():
        data = (
            read_reference("sphere_compression", REFERENCE)
            .where(material=name, mesh_n="20")
            .between("delta_over_R", 0.05, 0.4)
        )
        grid = make_ball(radius, even(8, 1.3), even(6, 1.3), 4, Turn(1))
        pressing = make_pressing(grid, radius, material.with_bulk_ratio(2000.0), 5.0)
        depths = data["delta_over_R"] * radius
        found = pressing.follow([*np.linspace(0.1, 0.5, 5)[:-1], *depths])[4:]
        equator = grid.near(2, 0.0) & grid.near(1, 0.0) & grid.near(0, radius)
        at = [f"d/R = {value:g}" for value in data["delta_over_R"]]
        bulge = [item.state.u[equator, 0][0] for item in found]
        rows += [
            compare(f"force, {name}, N", [4 * item.loads.force[2] for item in found], data["force_N"], 1e-2, at),
            compare(
                f"energy of half the sphere, {name}, mJ",
                [4 * item.loads.elastic for item in found],
                data["strain_energy_mJ_half"],
                1e-2,
                at,
            ),
            compare(f"bulge at the equator, {name}, mm", bulge, data["equator_ur_mm"], 1e-2, at),
        ]
    return rows


def hertz_round(obstacle: str) -> list[Row]:
    """Compare the force of a soft sphere under a rigid ball or bar (`cylinder`) with Hertz's law.

    With the relative curvatures 1/R' <= 1/R'' of the pair, the patch is an ellipse of eccentricity e (Johnson 1985,
    section 4.2): ``B/A = ((a/b)² E(e) - K(e)) / (K(e) - E(e))`` of ``A = 1/2R'``, ``B = 1/2R''``;
    ``d = p0 b K(e) / E*``, ``A = p0 b (K(e) - E(e)) / (E* e² a²)``, ``F = 2/3 pi a b p0``. As in `hertz` the ratio is
    extrapolated to small patches, for which Hertz's law is exact. Depths are up to d/R = 0.002.
    """
    radius, depths = 10.0, np.array([0.01, 0.02])
    found, exact = [], []
    for depth in depths:
        force, longest = _hertz_force(radius, depth, obstacle)
        middle = np.array([0.0, 0.0, 2 * radius])
        rigid = Ball(radius, middle) if obstacle == "ball" else Cylinder(radius, middle, np.array([1.0, 0.0, 0.0]))
        pressing = make_pressing(make_fine_ball(radius, longest), radius, YEOH, longest, rigid)
        found.append(4 * float(pressing.follow([depth])[0].loads.force[2]))
        exact.append(force)
    ratio = np.array(found) / np.array(exact)
    _, limit = np.polyfit(np.sqrt(depths / radius), ratio, 1)
    at = [f"d/R = {depth / radius:g}" for depth in depths]
    return [
        compare("force, N", np.array(found), np.array(exact), 2e-2, at),
        compare("force over Hertz's", limit, 1.0, 1e-2, ["a/R = 0"]),
    ]


def _hertz_force(radius: float, depth: float, obstacle: str) -> tuple[float, float]:
    """Return force (N) and longer semi-axis (mm) of Hertz's patch under a ball or bar of the same radius."""
    modulus = YEOH.young_modulus / (1 - 0.5**2)
    if obstacle == "ball":
        return 4 / 3 * modulus * np.sqrt(radius / 2) * depth**1.5, float(np.sqrt(radius / 2 * depth))
    least, most = 1 / (2 * radius), 1 / radius

    def miss(square: float) -> float:
        K, E = ellipk(square), ellipe(square)
        return float((E / (1 - square) - K) / (K - E) - most / least)

    square = brentq(miss, 1e-6, 1 - 1e-9)
    K, E = ellipk(square), ellipe(square)
    a = float(np.sqrt(depth * (K - E) / (K * square * least)))
    b = a * np.sqrt(1 - square)
    return float(2 / 3 * np.pi * a * b * depth * modulus / (K * b)), a


def scaling() -> list[Row]:
    """Compare forces of a compressed sphere of different stiffness, and of different size at equal strain."""
    stiff = Material("threefold", NeoHooke(3 * 0.0141156))
    soft = Material("once", NeoHooke(0.0141156))
    once, thrice, twice_as_large = _compress(soft, 1.0), _compress(stiff, 1.0), _compress(soft, 2.0)
    at = [f"d/R = {0.1 * depth:g}" for depth in _TENTHS]
    return [
        compare("force of a material three times as stiff, N", thrice[0], 3 * once[0], 1e-8, at),
        compare("force at twice the size, N", twice_as_large[0], 4 * once[0], 1e-8, at),
        compare("energy at twice the size, mJ", twice_as_large[1], 8 * once[1], 1e-8, at),
    ]


def _compress(material: Material, size: float) -> np.ndarray:
    """Forces (N) and energies (mJ), (2, n), of a coarse sphere of radius 10 mm times `size`."""
    radius = 10.0 * size
    pressing = make_pressing(make_ball(radius, even(4), even(2), 2, Turn(1)), radius, material, 0.4 * radius)
    found = pressing.follow([0.1 * radius * depth for depth in _TENTHS])
    return np.array([[item.loads.force[2], item.loads.elastic] for item in found]).T
