"""Barrels under a wall at their side: mirror images, turns, work, clamps, tubes under pressure by closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.design import Dome, MarkerSpec, place_markers
from palpate.design.barrel import BarrelSpec
from palpate.fea import BallSpec, Branch, Press, WallSpec, export_press, read_obstacle, read_press, write_press
from palpate.fea.loaded_skin import clamp_skin
from palpate.fea.side_wall import SideWallSpec
from palpate.material import get_material
from palpate.mechanics import DeadLoad, EndReason, Problem, SolverSpec, make_linear_solver
from palpate.mesh import Mesh, MeshSpec, gauss_points, mesh_skin, shape_quadrilateral
from presses import solve_press

SKIN = BarrelSpec().build()
SILICONE = get_material("neo-hooke:0.02176").with_bulk_ratio(9.667)
COARSE = MeshSpec(cells=8, core=2)
YOUNG, POISSON = 0.1262, 0.45


def pressed(tilt_deg: float, mesh: Mesh | None = None, depth: float = 2.0, azimuth_deg: float = 0.0) -> Press:
    wall = SideWallSpec(
        tilt_deg=tilt_deg, depth=depth, depth_step=1.0, contact="frictionless", azimuth_deg=azimuth_deg
    )
    return solve_press(mesh or mesh_skin(SKIN, COARSE), SILICONE, wall, SolverSpec(tolerance=1e-8))


@pytest.fixture(scope="module")
def leaning() -> Press:
    return pressed(93.0)


def test_a_press_above_the_middle_is_the_mirror_image_of_one_below(leaning: Press) -> None:
    other = pressed(87.0)
    points = place_markers(SKIN, MarkerSpec(rows=8, around=8, pitch=30)).positions
    flip = np.array([1.0, 1.0, -1.0])
    turned = other.positions(points * flip + [0, 0, SKIN.height]) * flip + [0, 0, SKIN.height]
    assert turned == pytest.approx(leaning.positions(points), abs=1e-4)
    assert other.force * flip == pytest.approx(leaning.force, rel=1e-4, abs=1e-7)
    assert np.abs(leaning.displacement_at(points)[-1]).max() > 0.5


def test_the_exported_gap_is_the_distance_to_the_wall_at_the_side(leaning: Press, tmp_path: Path) -> None:
    meshio = needs("meshio")
    export_press(tmp_path / "press", leaning)
    for number in range(len(leaning.depth)):
        gap = meshio.read(tmp_path / "press" / f"press_{number:04d}.vtu").point_data["wall_gap_mm"]
        assert gap[leaning.mesh.outer_faces].min() == pytest.approx(0, abs=0.02)


def test_the_force_is_along_the_normal_and_its_work_is_stored(leaning: Press) -> None:
    normal = np.array([0.0, -np.cos(np.radians(3)), -np.sin(np.radians(3))])
    assert leaning.ended is EndReason.DEPTH_REACHED
    assert (leaning.branch == Branch.FLAT).all()
    along = leaning.force @ normal
    assert (along[1:] > 0).all()
    assert np.linalg.norm(leaning.force - along[:, None] * normal, axis=1).max() < 1e-9
    stored = leaning.energy + leaning.contact_energy
    assert leaning.work[-1] == pytest.approx(stored[-1], rel=0.02)
    mean = 0.5 * along[-1] * leaning.depth[-1]  # a little more than linear
    assert mean == pytest.approx(stored[-1], rel=0.2)


def test_the_patch_lies_against_the_wall_and_nothing_is_behind_it(leaning: Press) -> None:
    normal = np.array([0.0, -np.cos(np.radians(3)), -np.sin(np.radians(3))])
    touch = SKIN.support_point(normal) - 2.0 * normal
    outer = (leaning.mesh.nodes + leaning.displacement[-1])[np.unique(leaning.mesh.outer_faces)]
    reach = (outer - touch) @ normal
    assert reach.max() == pytest.approx(0.0, abs=0.02)
    assert np.abs(leaning.displacement[:, leaning.mesh.base]).max() == 0.0


def test_a_whole_barrel_under_a_wall_at_an_azimuth_is_the_half_one_turned(leaning: Press) -> None:
    whole = pressed(93.0, mesh_skin(SKIN, MeshSpec(cells=8, core=2, whole=True)), depth=1.0, azimuth_deg=40.0)
    turned = replace(leaning, obstacle=leaning.obstacle.model_copy(update={"azimuth_deg": 40.0}))
    points = place_markers(SKIN, MarkerSpec(rows=6, around=10, pitch=35)).positions
    assert whole.positions(points)[1] == pytest.approx(turned.positions(points)[1], abs=2e-3)
    half = np.linalg.norm(leaning.force[1])
    assert np.linalg.norm(whole.force[1]) == pytest.approx(half, rel=1e-3)
    arm = np.array([np.sin(np.radians(40.0)), -np.cos(np.radians(40.0))])
    assert whole.force[1, :2] == pytest.approx(half * np.cos(np.radians(3)) * arm, rel=2e-3, abs=1e-6)


def test_a_barrel_that_is_loose_at_its_far_end_is_softer(leaning: Press) -> None:
    """A control: both clamps bear."""
    mesh = leaning.mesh
    rim = mesh.base[mesh.nodes[mesh.base, 2] < 1.0]
    loose = pressed(93.0, replace(mesh, base=rim))
    assert np.linalg.norm(loose.force[-1]) < 0.85 * np.linalg.norm(leaning.force[-1])


def test_friction_holds_and_costs_work(leaning: Press) -> None:
    wall = leaning.obstacle.model_copy(update={"contact": 0.6})
    held = solve_press(leaning.mesh, SILICONE, wall)
    assert np.linalg.norm(held.force[-1]) > np.linalg.norm(leaning.force[-1])
    assert held.dissipation[-1] > 0


def pressurise(skin_spec: BarrelSpec, pressure: float, loose: bool = False) -> tuple[Mesh, np.ndarray]:
    """Mesh of a barrel and its displacement (n, 3) mm under a small pressure inside, as dead forces on its nodes."""
    mesh = mesh_skin(skin_spec.build(), MeshSpec(cells=60, core=2))
    force = np.zeros_like(mesh.nodes)
    points, weights = gauss_points((3, 3))
    shape, gradient = shape_quadrilateral(points)
    for face in mesh.inner_faces:
        a, b = (np.einsum("qa,ai->qi", gradient[..., k], mesh.nodes[face]) for k in (0, 1))
        force[face] += pressure * np.einsum("q,qa,qi->ai", weights, shape, np.cross(a, b))
    if np.sum(force[:, :2] * mesh.nodes[:, :2]) < 0:
        force = -force
    if loose:
        mesh = replace(mesh, base=mesh.base[mesh.nodes[mesh.base, 2] < 1.0])
    solid = clamp_skin(mesh, SILICONE)
    problem = Problem(solid, make_linear_solver("auto"), 1e-9, 1.0)
    found = problem.solve(solid.rest(), (DeadLoad(force),), 20)
    assert found.converged
    return mesh, found.state.u


def test_a_tube_under_pressure_widens_as_lame_and_the_bending_of_its_clamped_ends_say() -> None:
    """Lamé's thick tube; near the ends Timoshenko's ``w (1 - exp(-βz)(cos βz + sin βz))``.

    The clamps are as far apart as before, so the axial force is that of the mean widening ``w (1 - 2/βL)``, and the
    middle, which is shortened a little, is wider than without axial strain by the share ``2 ν²/βL``.
    """
    inner, thickness, length, pressure = 30.0, 1.0, 200.0, 1e-6
    outer = inner + thickness
    mesh, moved = pressurise(
        BarrelSpec(height=length, base_radius=inner, middle_radius=inner + 1e-3, thickness=thickness), pressure
    )
    axial = np.unique(mesh.inner_faces)
    z, radius = mesh.nodes[axial, 2], np.hypot(mesh.nodes[axial, 0], mesh.nodes[axial, 1])
    out = (moved[axial, :2] * mesh.nodes[axial, :2]).sum(axis=1) / radius
    lame = pressure * inner * (1 + POISSON) / YOUNG * ((1 - 2 * POISSON) * inner**2 + outer**2)
    lame /= outer**2 - inner**2
    beta = (3 * (1 - POISSON**2)) ** 0.25 / np.sqrt((inner + thickness / 2) * thickness)
    lame *= 1 + 2 * POISSON**2 / (beta * length)
    middle = np.abs(z - length / 2) < 50
    assert out[middle] == pytest.approx(lame, rel=2e-3)
    near = (z > 0) & (z < 60)
    bent = lame * (1 - np.exp(-beta * z) * (np.cos(beta * z) + np.sin(beta * z)))
    assert np.abs(out - bent)[near].max() < 0.04 * lame


def test_a_tube_with_a_loose_end_does_not(leaning: Press) -> None:
    """A control: at a loose end the tube widens, and its closed form is another."""
    spec = BarrelSpec(height=200, base_radius=30.0, middle_radius=30.001, thickness=3.0)
    mesh, moved = pressurise(spec, 1e-6, loose=True)
    far = mesh.nodes[:, 2] > 199.9
    assert np.abs(moved[far]).max() > 0.5 * np.abs(moved).max()


def test_a_press_is_written_and_read_again(leaning: Press, tmp_path) -> None:  # type: ignore[no-untyped-def]
    write_press(tmp_path / "press.h5", leaning)
    again = read_press(tmp_path / "press.h5")
    assert again.obstacle == leaning.obstacle
    assert again.mesh.nodes == pytest.approx(leaning.mesh.nodes)
    points = place_markers(SKIN, MarkerSpec(rows=4, around=4, pitch=30)).positions
    assert again.positions(points) == pytest.approx(leaning.positions(points), abs=1e-5)


def test_words_are_read_and_a_wall_reaches_the_nearer_clamp() -> None:
    wall = read_obstacle("side_wall:tilt_deg=95", WallSpec(depth=9.0, contact=0.6))
    assert (wall.radial, wall.depth, wall.contact) == (95.0, 9.0, 0.6)
    mesh = mesh_skin(SKIN, COARSE)
    reach = SKIN.arc_radius + SKIN.thickness
    lean = np.arcsin(130 / reach) - np.radians(5)
    assert wall.clamp_depth(mesh) == pytest.approx(reach * (1 - np.cos(lean)), rel=1e-6)
    assert SideWallSpec(tilt_deg=85).clamp_depth(mesh) == pytest.approx(wall.clamp_depth(mesh))


@pytest.mark.parametrize("obstacle", [WallSpec(depth=1.0), BallSpec(depth=1.0)])
def test_what_comes_down_along_the_axis_is_refused(obstacle: WallSpec | BallSpec) -> None:
    with refused("obstacle-needs-apex"):
        solve_press(mesh_skin(SKIN, COARSE), SILICONE, obstacle)


def test_other_skins_steep_tilts_other_states_and_derivatives_are_refused() -> None:
    mesh = mesh_skin(SKIN, COARSE)
    with refused("side-wall-needs-barrel", "H20 T2"):
        solve_press(mesh_skin(Dome(20.0, 20.0, 2.0), MeshSpec(cells=6)), SILICONE, SideWallSpec())
    with refused("side-wall-touches-end", "106"):
        solve_press(mesh, SILICONE, SideWallSpec(tilt_deg=106.0))
    with refused("inverted-state-skin", "barrel 50"):
        solve_press(mesh, SILICONE, SideWallSpec(), branch=Branch.INVERTED)
    with refused("derivative-unknown", "tilt_deg"):
        solve_press(mesh, SILICONE, SideWallSpec(depth=0.5), SolverSpec(derivatives=("tilt_deg",)))
