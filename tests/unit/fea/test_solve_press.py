"""A press: what it must satisfy whatever its numbers are."""

from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.design import DomeSpec, Rim, build_skin, turn_about_axis, wall_normal
from palpate.fea import Branch, Press, WallSpec, read_press, write_press
from palpate.material import get_material
from palpate.mechanics import EndReason, SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")


def press(height: float = 20, thickness: float = 2, cells: int = 9, whole: bool = False, **wall: object) -> Press:
    mesh = mesh_skin(build_skin(DomeSpec(height=height, thickness=thickness)), MeshSpec(cells=cells, whole=whole))
    return solve_press(mesh, ECOFLEX, WallSpec(**{"depth": 2.4, "contact": "frictionless", **wall}))


@pytest.fixture(scope="module")
def tilted() -> Press:
    return press(tilt_deg=10)


def ring(count: int = 24) -> np.ndarray:
    azimuth = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([12 * np.cos(azimuth), 12 * np.sin(azimuth), np.full(count, 16.0)], -1)


def test_a_frictionless_wall_pushes_along_its_normal(tilted: Press) -> None:
    normal = wall_normal(np.radians(10), 0)
    along = tilted.force[1:] @ normal
    across = np.linalg.norm(tilted.force[1:] - along[:, None] * normal, axis=1)
    assert (along > 0).all()
    assert (across < 1e-6 * along).all()


def test_the_wall_works_as_much_as_the_dome_stores() -> None:
    tilted = press(tilt_deg=10, cells=18)
    assert tilted.work[-1] == pytest.approx(tilted.energy[-1] + tilted.contact_energy[-1], rel=2e-3)


def test_images_come_at_every_step_and_say_their_branch(tilted: Press) -> None:
    assert tilted.depth == pytest.approx([0, 0.8, 1.6, 2.4])
    assert set(tilted.branch) == {Branch.FLAT}
    assert tilted.ended is EndReason.DEPTH_REACHED
    assert (np.diff(tilted.contact_area) > 0).all()
    assert (np.diff(tilted.peak_stress) > 0).all()


def test_a_mirrored_point_moves_mirrored(tilted: Press) -> None:
    points = ring()
    moved = tilted.positions(points)
    mirrored = tilted.positions(points * [-1, 1, 1])
    assert mirrored == pytest.approx(moved * [-1, 1, 1], abs=1e-12)


@pytest.mark.parametrize("azimuth", [40, 200])
def test_a_turned_wall_turns_the_solution(tilted: Press, azimuth: float) -> None:
    turned = press(tilt_deg=10, azimuth_deg=azimuth)
    turn = turn_about_axis(np.radians(azimuth))
    assert turned.positions(ring() @ turn.T) == pytest.approx(tilted.positions(ring()) @ turn.T, abs=1e-9)
    assert turned.force == pytest.approx(tilted.force @ turn.T, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["frictionless", "no-slip"])
def test_a_whole_dome_agrees_with_the_turned_half(contact: str) -> None:
    half = press(tilt_deg=8, azimuth_deg=35, contact=contact, cells=12)
    whole = press(tilt_deg=8, azimuth_deg=35, contact=contact, cells=12, whole=True)
    gap = np.linalg.norm(whole.positions(ring()) - half.positions(ring()), axis=-1)[1:] / half.depth[1:, None]
    assert np.sqrt((gap**2).mean(axis=1)).max() < 0.005
    assert gap.max() < 0.015
    assert whole.force[-1] == pytest.approx(half.force[-1], abs=0.01 * np.linalg.norm(half.force[-1]))


def test_stiffness_scales_force_and_not_shape() -> None:
    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=8))
    wall = WallSpec(depth=1.6, contact="frictionless", tilt_deg=3)
    soft = solve_press(mesh, get_material("yeoh:0.0141156,0.0001106,0.0000048"), wall)
    stiff = solve_press(mesh, get_material("yeoh:0.0282312,0.0002212,0.0000096"), wall)
    assert stiff.force == pytest.approx(2 * soft.force, rel=1e-6, abs=1e-12)
    assert stiff.displacement == pytest.approx(soft.displacement, abs=1e-6)


def test_no_slip_holds_points_where_they_touched() -> None:
    stuck, sliding = press(contact="no-slip"), press()
    assert stuck.force[-1, 2] > 1.02 * sliding.force[-1, 2]
    middle = press(contact=0.3)
    assert sliding.force[-1, 2] < middle.force[-1, 2] < stuck.force[-1, 2]


def test_a_press_ends_where_the_wall_reaches_the_clamp() -> None:
    low = press(height=8, thickness=4, tilt_deg=25, depth=8, cells=8)
    expected = low.mesh.skin.clamp_depth(np.radians(25), Rim.FLAT)
    assert 3 < expected < 4
    assert low.ended is EndReason.WALL_AT_CLAMP
    assert low.ended_depth == pytest.approx(expected)
    assert f"{expected:.3f} mm of 8 mm" in low.message


def test_clamp_depth_is_that_of_the_notes() -> None:
    dome = build_skin(DomeSpec(height=10, thickness=1))
    depths = [dome.clamp_depth(np.radians(tilt), Rim.RADIAL) for tilt in (5, 7, 10)]
    assert depths == pytest.approx([8.7, 8.0, 7.1], abs=0.06)


def test_a_wall_that_meets_the_rim_first_is_refused() -> None:
    with refused("rim-touched-first"):
        press(height=3, thickness=1, tilt_deg=25)


def test_a_press_survives_its_file(tilted: Press, tmp_path: Path) -> None:
    write_press(tmp_path / "press.h5", tilted)
    again = read_press(tmp_path / "press.h5")
    assert again.positions(ring()) == pytest.approx(tilted.positions(ring()), abs=1e-5)
    assert again.force == pytest.approx(tilted.force)
    assert list(again.branch) == list(tilted.branch)
    assert again.obstacle == tilted.obstacle
    (tmp_path / "broken.h5").write_bytes((tmp_path / "press.h5").read_bytes()[:500])
    with refused("press-unreadable"):
        read_press(tmp_path / "broken.h5")


def test_backends_agree() -> None:
    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=6))
    wall = WallSpec(depth=0.8, contact="frictionless")
    forces = [solve_press(mesh, ECOFLEX, wall, SolverSpec(backend=name)).force[-1, 2] for name in ("auto", "superlu")]
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)


@pytest.mark.parametrize(
    ("contact", "code"),
    [
        ("sticky", "contact-unknown"),
        ("nan", "contact-unknown"),
        (-0.1, "friction-out-of-bounds"),
        (11, "friction-out-of-bounds"),
    ],
)
def test_an_unknown_contact_law_is_refused(contact: object, code: str) -> None:
    with refused(code):
        WallSpec(contact=contact)
