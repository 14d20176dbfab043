"""Torsion of a solid cylinder, bending of a block to a sector, and large bending of a cantilever.

*Torsion* without axial strain (Rivlin 1949): a section at z turns by psi z, ``M = 4 pi psi ∫ W' r³ dr`` and
``N = -psi M / 2``. *Bending* in plane strain (Rivlin 1949): ``r² = ri² + 2 A X``, ``theta = Y / A``, with
``A = L / angle``.
The ends are prescribed from these solutions, the rest is free; moments and forces are those of the reactions.
*Cantilever*: a slender one follows the elastica, ``EI theta'' = -P cos theta``, under a dead force across its end,
and rolls up to a circle under a moment.
"""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.material import Material, NeoHooke
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import find_equilibrium, follow_load, make_solid, reactions
from palpate.verify.mapped import Grid, Turn, even, join, map_block, revolve
from palpate.verify.read_reference import read_reference
from palpate.verify.rubber import MATERIALS

RADIUS, LENGTH = 10.0, 1.0
"""Cylinder under torsion, mm; its length does not matter."""
HEIGHT, SPAN, WIDTH = 4.0, 20.0, 1.0
"""Block under bending, mm; half its span is solved."""
_THIN, _HALF_WIDTH = 0.1, 0.05
"""Cantilever: height, half its width (mm)."""
_INERTIA = 2 * _HALF_WIDTH * _THIN**3 / 12
"""Moment of inertia of the whole cantilever, mm⁴."""
_LOAD = "load_parameter(PL2/EI or ML/EI)"


def torsion() -> list[Row]:
    """Moment and axial force against the shear at the surface."""
    rows = []

    def section(q: FloatArray) -> FloatArray:
        return np.column_stack([RADIUS * q[:, 0], LENGTH * q[:, 1]])

    grid = join(revolve(section, (even(4), even(1)), Turn(2, quarters=4), solid=True))
    for name, material in MATERIALS.items():
        data = read_reference("torsion_solid_cylinder_R10").where(material=name)
        found = np.array([_twist(grid, material, psi) for psi in data["psi_rad_per_mm"]])
        at = [f"shear {value:g}" for value in data["gamma_surface"]]
        rows += [
            compare(f"moment, {name}, N mm", found[:, 0], data["moment_N_mm"], 2e-3, at),
            compare(f"axial force, {name}, N", found[:, 1], data["axial_force_N"], 2e-3, at),
        ]
    return rows


def _twist(grid: Grid, material: Material, psi: float) -> tuple[float, float]:
    """Moment (N mm) and axial force (N) on the upper end, turned by psi (rad/mm)."""
    top = grid.near(2, LENGTH)
    fixed = np.repeat((top | grid.near(2, 0.0))[:, None], 3, axis=1)
    solid = make_solid(grid, material, fixed)
    x, y, z = grid.nodes.T
    cos, sin = np.cos(psi * z), np.sin(psi * z)
    exact = np.column_stack([x * cos - y * sin - x, x * sin + y * cos - y, 0 * z])
    state = find_equilibrium(solid, exact).state
    force, (x, y, _) = reactions(solid, state)[top], (grid.nodes + state.u)[top].T
    return float((x * force[:, 1] - y * force[:, 0]).sum()), float(force[:, 2].sum())


def make_block(across: int, along: int) -> Grid:
    """Mesh half the span of the block: x through its height, y along it, one cell in z."""
    size = np.array([HEIGHT, SPAN / 2, WIDTH])
    return join(map_block((even(across), even(along), even(1)), lambda q: q * size))


def solve_bending(grid: Grid, material: Material, angle: float, inner: float) -> tuple[float, float]:
    """Bend half a block.

    Parameters
    ----------
    grid
        Of `make_block`.
    material
        Its material.
    angle, inner
        Angle of the whole sector, rad, and its inner radius, mm.

    Returns
    -------
    moment, energy
        Per width, N, and stored in the half block, mJ.
    """
    end = grid.near(1, SPAN / 2)
    fixed = np.repeat(end[:, None], 3, axis=1)
    fixed[:, 2] = True
    fixed[grid.near(1, 0.0), 1] = True
    solid = make_solid(grid, material, fixed)
    radius = np.sqrt(inner**2 + 2 * SPAN / angle * grid.nodes[:, 0])
    theta = grid.nodes[:, 1] * angle / SPAN
    bent = np.column_stack([radius * np.cos(theta), radius * np.sin(theta), grid.nodes[:, 2]])
    centre = np.array([-inner, 0.0, 0.0])
    found = find_equilibrium(solid, bent + centre - grid.nodes)
    force = reactions(solid, found.state)[end]
    x, y, _ = (grid.nodes + found.state.u - centre)[end].T
    return float((x * force[:, 1] - y * force[:, 0]).sum() / WIDTH), found.loads.elastic


def block_bending() -> list[Row]:
    """Moment per width against the angle, up to a full turn."""
    rows, grid = [], make_block(4, 12)
    for name, material in MATERIALS.items():
        data = read_reference("block_bending_h4_L20").where(material=name)
        moment = [
            solve_bending(grid, material, angle, inner)[0]
            for angle, inner in zip(data["angle_rad"], data["r_inner_mm"], strict=True)
        ]
        at = [f"{value:g} rad" for value in data["angle_rad"]]
        rows.append(compare(f"moment per width, {name}, N", moment, data["moment_per_width_N"], 5e-3, at))
    return rows


def cantilever() -> list[Row]:
    """Tip of a cantilever of length 10 under a dead force across its end."""
    length = 10.0
    grid, material, fixed, end = _make_cantilever(length)
    load = np.zeros(grid.nodes.shape)
    weight = np.ones(np.count_nonzero(end))
    for axis in (1, 2):
        middle = np.mean([grid.nodes[end, axis].min(), grid.nodes[end, axis].max()])
        weight *= np.where(np.abs(grid.nodes[end, axis] - middle) < 1e-9, 4 / 6, 1 / 6)
    load[end, 2] = 0.5 * material.young_modulus * _INERTIA / length**2 * weight
    data = read_reference("elastica_exact").where(case="end_shear")
    parameter = data[_LOAD]
    states = follow_load(grid, material, fixed, load, parameter)
    tip = end & grid.near(1, 0.0) & grid.near(2, 0.0)
    moved = np.array([state.u[tip][0] for state in states])
    at = [f"PL²/EI = {value:g}" for value in parameter]
    return [
        compare("deflection of the tip, mm", moved[:, 2], data["w_tip"], 3e-3, at),
        compare("shortening over the deflection, mm", -moved[:, 0], data["minus_u_tip"], 3e-3, at, data["w_tip"]),
    ]


def cantilever_moment() -> list[Row]:
    """Compare the end moment of a cantilever of length 12, bent by the elastica up to a full circle."""
    length = 12.0
    grid, material, fixed, end = _make_cantilever(length)
    fixed[end, 0] = fixed[end, 2] = True
    solid = make_solid(grid, material, fixed)
    data = read_reference("elastica_exact").where(case="end_moment")
    unit = 0.5 * material.young_modulus * _INERTIA / length
    x, _, z = grid.nodes.T
    moment, state = [], solid.rest()
    for angle, u_tip, w_tip in zip(data[_LOAD], data["minus_u_tip"], data["w_tip"], strict=True):
        turn = angle * x / length
        bent = np.column_stack(
            [(length / angle - z) * np.sin(turn), 0 * x, length / angle * (1 - np.cos(turn)) + z * np.cos(turn)]
        )
        bent[:, 0] -= x
        bent[:, 2] -= z
        bent[end, 0] = length - u_tip - z[end] * np.sin(angle) - x[end]
        bent[end, 2] = w_tip + z[end] * np.cos(angle) - z[end]
        state = find_equilibrium(solid, bent, pressure=state.p).state
        pull = reactions(solid, state)[end]
        arm = (grid.nodes + state.u)[end] - [length - u_tip, 0.0, w_tip]
        moment.append(float((arm[:, 0] * pull[:, 2] - arm[:, 2] * pull[:, 0]).sum()) / unit)
    at = [f"ML/EI = {value:.3g}" for value in data[_LOAD]]
    return [compare("ML/EI", moment, data[_LOAD], 3e-3, at)]


def _make_cantilever(length: float) -> tuple[Grid, Material, BoolArray, BoolArray]:
    """Return half the width of a cantilever, its material, the fixed components, and the nodes of its end."""
    size = np.array([length, _HALF_WIDTH, _THIN])
    grid = join(map_block((even(48), even(1), even(1)), lambda q: q * size - [0.0, 0.0, _THIN / 2]))
    fixed = np.zeros(grid.nodes.shape, bool)
    root = grid.near(0, 0.0)
    fixed[root, 0] = True
    fixed[root & grid.near(2, 0.0), 2] = True
    fixed[grid.near(1, 0.0), 1] = True
    return grid, Material("stiff neo-Hooke", NeoHooke(1e5), bulk_ratio=4.0), fixed, grid.near(0, length)
