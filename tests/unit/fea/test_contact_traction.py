"""Contact traction of a press by equilibrium: sums, Hertz's pressure, the penalty and Coulomb's law."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.core import FloatArray
from palpate.design import DomeSpec, build_skin
from palpate.fea import BallSpec, ObstacleSpec, Press, WallSpec, contact_traction, export_press
from palpate.fea.contact_traction import surface_traction
from palpate.fea.loaded_skin import load_surface
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press
from validation.ball import YEOH, make_fine_ball, make_pressing

SILICONE = get_material("zaid_2024_ecoflex_00_30")
OBSTACLES = {
    "stuck": WallSpec(tilt_deg=8, azimuth_deg=90, depth=3.2),
    "turned": WallSpec(tilt_deg=8, azimuth_deg=30, depth=1.6, contact=0.5),
    "ball": BallSpec(radius=8, depth=2.4, contact=0.8),
    "slippery": WallSpec(depth=2.4, contact="frictionless"),
}


def pressed(obstacle: ObstacleSpec, *, whole: bool = False) -> Press:
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=3)), MeshSpec(cells=8, whole=whole))
    return solve_press(mesh, SILICONE, obstacle)


def total(press: Press) -> FloatArray:
    """Force (n, 3) N of the whole skin on the obstacle in the skin's frame, from the traction."""
    found = contact_traction(press)
    force = (found.traction * found.area[..., None]).sum(axis=1)
    if not press.mesh.spec.whole:
        force = 2.0 * force * [0.0, 1.0, 1.0]
    return np.asarray(force @ press.obstacle.turn(press.mesh).T)


@pytest.mark.parametrize("name", OBSTACLES)
def test_the_traction_sums_to_the_force_of_contact(name: str) -> None:
    press = pressed(OBSTACLES[name])
    size = np.linalg.norm(press.force[-1])
    assert np.abs(total(press) - press.force).max() < 0.005 * size
    assert contact_traction(press).pressure[0] == pytest.approx(0.0, abs=1e-9)


def test_a_whole_skin_has_the_traction_of_its_half() -> None:
    half, whole = (pressed(OBSTACLES["turned"], whole=each) for each in (False, True))
    assert total(whole)[-1] == pytest.approx(half.force[-1], rel=0.01, abs=1e-4)
    peaks = [contact_traction(each).pressure[-1].max() for each in (half, whole)]
    assert peaks[1] == pytest.approx(peaks[0], rel=0.1)


def test_the_pressure_is_hertzs_in_a_light_contact() -> None:
    """Johnson 1985, chapter 4: p = p0 sqrt(1 - r²/a²), p0 = 2 E* / pi sqrt(d / R), of a ball under a plane."""
    radius, depth = 10.0, 0.01
    reach = np.sqrt(radius * depth)
    pressing = make_pressing(make_fine_ball(radius, reach), radius, YEOH, reach)
    found = pressing.follow([depth])[0]
    traction, area = surface_traction(pressing.solid, pressing.surface, found.state)
    x, y, _ = (pressing.solid.nodes + found.state.u).T
    inside = (area > 0) & (x > 1e-6) & (y > 1e-6) & (np.hypot(x, y) < 0.8 * reach)
    peak = 2.0 * YEOH.young_modulus / 0.75 / np.pi * np.sqrt(depth / radius)
    exact = peak * np.sqrt(1.0 - (x**2 + y**2)[inside] / reach**2)
    assert inside.sum() > 20
    assert traction[inside, 2] == pytest.approx(exact, rel=0.02)
    pole = (area > 0) & (np.hypot(x, y) < 1e-6)
    assert traction[pole, 2] == pytest.approx(peak, rel=0.01)


def test_without_friction_it_lies_where_the_penalty_acts() -> None:
    """The penetration at the quadrature points gives the same mean square of the distance from the axis."""
    press = pressed(OBSTACLES["slippery"])
    found, mesh, u = contact_traction(press), press.mesh, press.displacement[-1]
    loading = load_surface(press.solver, mesh, SILICONE, press.obstacle)
    x = loading.surface.interpolate(mesh.nodes + u)
    reach = press.obstacle.path(mesh)(float(press.depth[-1])).penetration(x)
    force = loading.surface.faces.weight.ravel() * np.maximum(reach - 0.5 * loading.law.width, 0.0)
    nodal = found.pressure[-1] * found.area[-1]
    away = ((mesh.nodes + u)[:, :2] ** 2).sum(axis=1)
    assert nodal @ away / nodal.sum() == pytest.approx((x[:, :2] ** 2).sum(axis=1) @ force / force.sum(), rel=0.01)
    assert np.linalg.norm(found.shear[-1], axis=1).max() < 0.05 * found.pressure[-1].max()


def test_the_shear_follows_coulombs_law() -> None:
    press = pressed(OBSTACLES["ball"])
    found = contact_traction(press)
    pressure, shear = found.pressure[-1], np.linalg.norm(found.shear[-1], axis=1)
    much = pressure > 0.3 * pressure.max()
    assert (shear[much] < 1.1 * 0.8 * pressure[much]).all()
    assert np.einsum("ni,ni->n", found.shear[-1], found.normal[-1]) == pytest.approx(0.0, abs=1e-12)


def test_the_exported_contact_sums_to_the_exported_force(tmp_path: Path) -> None:
    needs("meshio")
    press = pressed(OBSTACLES["turned"])
    export_press(tmp_path / "press", press)
    with (tmp_path / "press" / "contact.csv").open(newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    last = [row for row in rows if row["depth_mm"] == pytest.approx(press.depth[-1])]
    force = [sum(row["area_mm2"] * row[f"t{axis}_mpa"] for row in last) for axis in "xyz"]
    assert force == pytest.approx(press.force[-1], abs=0.005 * float(np.linalg.norm(press.force[-1])))
    low = np.array([[row["x_mm"], row["y_mm"], row["z_mm"]] for row in last if row["pressure_mpa"] > 1e-3])
    normal = press.obstacle.turn(press.mesh) @ contact_traction(press).normal[-1, 0]
    assert np.ptp(low @ normal) < 0.1  # they lie on the wall


def test_a_press_by_another_solver_has_no_traction() -> None:
    with refused("press-no-nodal-stress", "calculix"):
        contact_traction(replace(pressed(OBSTACLES["slippery"]), solved_by="calculix"))
