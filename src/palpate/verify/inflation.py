"""Thick sphere and long thick cylinder under internal pressure, with prescribed cavity radius.

Both are incompressible: a point at R moves to ``r³ = R³ + a³ - Ri³`` (sphere) or ``r² = R² + a² - Ri²`` (cylinder),
and the pressure is an integral over the wall (Ogden, *Non-Linear Elastic Deformations*, 1984, sections 5.3.2 and
5.3.3). Prescribing the radius passes the limit point, where a prescribed pressure would jump. An eighth of the
sphere and a quarter of a slice of the cylinder are solved; the pressure is the virtual work of the reactions,
``p = sum f·x / (a area)``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from palpate.core import FloatArray
from palpate.material import Material
from palpate.mechanics import State, cauchy_stress
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import find_equilibrium, make_solid, reactions
from palpate.verify.mapped import Grid, Turn, even, join, revolve
from palpate.verify.read_reference import read_reference
from palpate.verify.rubber import MATERIALS

INNER, OUTER = 18.0, 20.0
"""Radii of the undeformed wall, mm."""
_LAYERS = 3
"""Cells through the wall, or along the slice."""
_HEIGHT = 2.0
"""Height of the slice of a cylinder, mm."""


@dataclass(frozen=True)
class Inflation:
    """A round cavity in a thick wall, inflated.

    Attributes
    ----------
    grid
        Its symmetric part.
    dimensions
        3 for a sphere, 2 for a cylinder along z.
    material
        The wall.
    """

    grid: Grid
    dimensions: int
    material: Material

    def radius(self, places: FloatArray) -> FloatArray:
        """Distance (n,) mm of places (n, 3) from the centre or the axis."""
        return np.linalg.norm(places[:, : self.dimensions], axis=1)

    def inflate(self, ratio: float) -> tuple[FloatArray, State, FloatArray]:
        """Return pressure (Pa) as (1,), state and reactions (n, 3) N at `ratio` times the cavity radius."""
        grid, power = self.grid, self.dimensions
        radius = self.radius(grid.nodes)
        cavity = np.abs(radius - INNER) < 1e-6
        fixed = np.stack([grid.near(axis, 0.0) for axis in range(3)], axis=-1)
        fixed[cavity, :power] = True
        if power == 2:
            fixed[:, 2] = True
        solid = make_solid(grid, self.material, fixed)
        stretch = (1 + (INNER / radius) ** power * (ratio**power - 1)) ** (1 / power)
        exact = grid.nodes * (stretch - 1)[:, None]
        if power == 2:
            exact[:, 2] = 0.0
        state = find_equilibrium(solid, exact).state
        force = reactions(solid, state)
        x = (grid.nodes + state.u)[cavity, :power]
        a = ratio * INNER
        area = 0.5 * np.pi * a**2 if power == 3 else 0.5 * np.pi * a * _HEIGHT
        pressure = (force[cavity, :power] * x).sum() / (a * area)
        return np.array([1e6 * pressure]), state, force

    def stresses(self, state: State) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Undeformed radius (n,) mm and radial and hoop Cauchy stress (n,), (n,) Pa, at all Gauss points."""
        solid = make_solid(self.grid, self.material, np.zeros(self.grid.nodes.shape, bool))
        places = np.einsum("ga,eai->egi", solid.shape, self.grid.nodes[self.grid.cells]).reshape(-1, 3)
        stress = 1e6 * cauchy_stress(solid, state).reshape(-1, 6)
        direction = places / np.linalg.norm(places, axis=1)[:, None]
        voigt = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
        along = np.einsum("ni,nij,nj->n", direction, stress[:, voigt], direction)
        return self.radius(places), along, 0.5 * (stress[:, :3].sum(axis=1) - along)


def make_sphere(material: Material) -> Inflation:
    """Make an eighth of the sphere."""

    def section(q: FloatArray) -> FloatArray:
        polar, r = 0.5 * np.pi * q[:, 0], INNER + (OUTER - INNER) * q[:, 1]
        return np.column_stack([r * np.sin(polar), r * np.cos(polar)])

    return Inflation(join(revolve(section, (even(8), even(_LAYERS)), Turn(2), solid=True)), 3, material)


def make_cylinder(material: Material) -> Inflation:
    """Make a quarter of a slice of the cylinder."""

    def section(q: FloatArray) -> FloatArray:
        return np.column_stack([INNER + (OUTER - INNER) * q[:, 0], _HEIGHT * q[:, 1]])

    return Inflation(join(revolve(section, (even(_LAYERS), even(1)), Turn(3), solid=False)), 2, material)


def _carry(radius: FloatArray, stress: FloatArray, to: FloatArray) -> FloatArray:
    """Extrapolate stresses from the Gauss points to other radii by a quartic, least squares."""
    return np.asarray(np.polynomial.Polynomial.fit(radius, stress, 4)(to))


def sphere_pressure() -> list[Row]:
    """Compare pressure and hoop stress at the faces by a/Ri, past both limit points."""
    rows = []
    for name, material in MATERIALS.items():
        data = read_reference("sphere_inflation_Ri18_Ro20").where(material=name)
        sphere = make_sphere(material)
        pressure, hoop = [], []
        for ratio in data["a_over_Ri"]:
            value, state, _ = sphere.inflate(ratio)
            radius, _, across = sphere.stresses(state)
            pressure.append(value[0])
            hoop.append(_carry(radius, across, np.array([INNER, OUTER])))
        at = [f"a/Ri = {ratio:g}" for ratio in data["a_over_Ri"]]
        inner, outer = np.array(hoop).T
        rows += [
            compare(f"pressure, {name}, Pa", pressure, data["pressure_Pa"], 1e-3, at),
            compare(f"hoop stress inside, {name}, Pa", inner, data["hoop_inner_Pa"], 1e-2, at),
            compare(f"hoop stress outside, {name}, Pa", outer, data["hoop_outer_Pa"], 1e-2, at),
        ]
    return rows


def sphere_limit_points() -> list[Row]:
    """Maximum and minimum of the pressure, by cubic splines through solutions 0.05 a/Ri apart."""
    data = read_reference("sphere_inflation_limit_points")
    found: list[tuple[float, float]] = []
    for name, ratio in zip(data.labels("material"), data["a_over_Ri"], strict=True):
        sphere = make_sphere(next(material for key, material in MATERIALS.items() if name.startswith(key)))
        near = np.round(ratio, 2) + 0.05 * np.arange(-3, 4)
        curve = CubicSpline(near, [sphere.inflate(value)[0][0] for value in near])
        turning = curve.derivative().roots(extrapolate=False)
        place = turning[np.argmin(np.abs(turning - ratio))]
        found.append((float(place), float(curve(place))))
    place, pressure = np.array(found).T
    at = data.labels("material", "kind")
    return [
        compare("pressure, Pa", pressure, data["pressure_Pa"], 1e-3, at),
        compare("a/Ri", place, data["a_over_Ri"], 1e-3, at),
    ]


def sphere_wall_profile() -> list[Row]:
    """Stress through the wall at a/Ri = 1.5."""
    rows = []
    for name, material in MATERIALS.items():
        data = read_reference("sphere_inflation_wall_profile").where(material=name)
        sphere = make_sphere(material)
        _, state, _ = sphere.inflate(data["a_over_Ri"][0])
        radius, along, across = sphere.stresses(state)
        at = [f"R = {value:g} mm" for value in data["R_mm"]]
        radial, hoop = (_carry(radius, stress, data["R_mm"]) for stress in (along, across))
        pressure = np.abs(data["sigma_r_Pa"]).max()
        rows += [
            compare(f"radial stress over the pressure, {name}, Pa", radial, data["sigma_r_Pa"], 1e-2, at, pressure),
            compare(f"hoop stress, {name}, Pa", hoop, data["sigma_theta_Pa"], 1e-2, at),
        ]
    return rows


def cylinder_pressure() -> list[Row]:
    """Pressure and axial force of the wall against a/Ri in plane strain."""
    rows = []
    for name, material in MATERIALS.items():
        data = read_reference("cylinder_inflation_Ri18_Ro20").where(material=name)
        cylinder = make_cylinder(material)
        top = cylinder.grid.near(2, _HEIGHT)
        pressure, axial = [], []
        for ratio in data["a_over_Ri"]:
            value, _, force = cylinder.inflate(ratio)
            pressure.append(value[0])
            axial.append(4 * force[top, 2].sum())
        at = [f"a/Ri = {ratio:g}" for ratio in data["a_over_Ri"]]
        rows += [
            compare(f"pressure, {name}, Pa", pressure, data["pressure_Pa"], 1e-3, at),
            compare(f"axial force of the wall, {name}, N", axial, data["wall_axial_force_N"], 1e-3, at),
        ]
    return rows
