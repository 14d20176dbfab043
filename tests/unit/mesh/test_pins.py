"""Pins against turned and inflated skins in closed form, against normals by differences, and in twins and fields."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from errors import refused
from palpate.design import DomeSpec, MarkerSpec, place_markers, skin_from_data
from palpate.design.pinned import PinnedDome, PinnedSpec
from palpate.fea import Press, WallSpec
from palpate.fea.variations import parameter_names
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import Mesh, MeshSpec, locate_inner, marker_displacement, marker_displacement_derivative, mesh_skin
from palpate.surrogate import TWIN_DERIVATIVES, build_field
from presses import build_twin, solve_press

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")
SPEC = PinnedSpec(height=20, thickness=2, pin=3)
SKIN = SPEC.build()
LAYOUT = place_markers(SKIN, MarkerSpec(ring_diameters=(8.0, 16.0, 24.0)))
STEP = 1e-3


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return mesh_skin(SKIN, MeshSpec(cells=20, whole=True))


def press(tilt: float, names: tuple[str, ...] = (), **wall: float) -> Press:
    spec = WallSpec(tilt_deg=tilt, depth=3.2, depth_step=0.4, **wall)
    return solve_press(
        mesh_skin(SKIN, MeshSpec(cells=16)), ECOFLEX, spec, SolverSpec(derivatives=names, edge_share=1.0)
    )


@pytest.fixture(scope="module")
def presses() -> list[Press]:
    return [press(tilt, ("tilt_deg", *TWIN_DERIVATIVES)) for tilt in (0.0, 4.0, 8.0, 12.0)]


def test_tips_stand_on_a_sphere_about_the_same_centre() -> None:
    arm = LAYOUT.positions - SKIN.wall.centre
    assert np.linalg.norm(arm, axis=1) == pytest.approx(17.0)
    assert np.hypot(*LAYOUT.positions[1:7, :2].T) == pytest.approx(4.0)


def test_a_skin_that_turns_as_a_whole_turns_its_tips(mesh: Mesh) -> None:
    turn, way = Rotation.from_rotvec([0.2, -0.4, 0.1]).as_matrix(), np.array([0.3, 0.1, -2.0])
    moved = mesh.nodes @ turn.T + way - mesh.nodes
    tips = LAYOUT.positions + marker_displacement(mesh, locate_inner(mesh, LAYOUT.positions), moved[None])[0]
    assert tips == pytest.approx(LAYOUT.positions @ turn.T + way, abs=5e-3)


def test_an_inflated_sphere_keeps_the_length_of_its_pins(mesh: Mesh) -> None:
    arm = mesh.nodes - SKIN.wall.centre
    tips = LAYOUT.positions + marker_displacement(mesh, locate_inner(mesh, LAYOUT.positions), 0.1 * arm[None])[0]
    assert np.linalg.norm(tips - SKIN.wall.centre, axis=1) == pytest.approx(1.1 * 20 - 3, abs=5e-4)


def test_a_rate_is_the_slope_of_the_motion(mesh: Mesh) -> None:
    rng = np.random.default_rng(5)
    x = mesh.nodes / 20
    state, rate = (np.sin(x @ rng.normal(size=(3, 3)) * 2)[None] for _ in range(2))
    places = locate_inner(mesh, LAYOUT.positions)
    high, low = (marker_displacement(mesh, places, state + side * 1e-4 * rate) for side in (1, -1))
    assert marker_displacement_derivative(mesh, places, state, rate) == pytest.approx((high - low) / 2e-4, abs=1e-6)


def test_tips_stand_on_the_normal_of_the_pressed_wall(presses: list[Press]) -> None:
    """The normal by differences of points of the wall, in the same press of the dome without its pins."""
    pressed = presses[2]
    bare = replace(pressed, mesh=replace(pressed.mesh, skin=SKIN.wall))
    roots = SKIN.wall.nearest(LAYOUT.positions)
    _, along, around = SKIN.wall.tangents(roots)
    ways = []
    for way in (along, around):
        high, low = (bare.positions(SKIN.wall.nearest(roots + side * STEP * way)) for side in (1, -1))
        ways.append(high - low)
    normal = np.cross(ways[0], ways[1])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    expected = bare.positions(roots) - 3.0 * normal
    off = pressed.positions(LAYOUT.positions) - expected
    assert np.abs(off).max() < 0.05
    assert np.sqrt(np.mean(off**2)) < 0.008
    moved = np.linalg.norm(pressed.positions(LAYOUT.positions)[-1] - LAYOUT.positions, axis=1)
    without = np.linalg.norm(bare.positions(roots)[-1] - roots, axis=1)
    assert np.abs(moved - without).max() > 0.3


def test_field_and_twin_follow_the_tips_of_a_press_between_theirs(presses: list[Press]) -> None:
    seen = press(6.0, azimuth_deg=40.0)
    rx, ry = 6.0 * np.cos(np.radians([40.0])), 6.0 * np.sin(np.radians([40.0]))
    expected = seen.positions(LAYOUT.positions)
    field = build_field(presses, LAYOUT)
    assert np.abs(field.positions(rx, ry, 7)[0] - expected[8]).max() < 0.03
    twin = build_twin(presses)
    found = twin.with_markers(LAYOUT.positions).evaluate(np.array([rx[0], ry[0], 3.2]), 0.0).positions
    assert np.abs(found - expected[8]).max() < 0.03


def test_a_derivative_by_tilt_foresees_the_tips_of_the_next_tilt(presses: list[Press]) -> None:
    here, high, low = presses[1], press(4.5), press(3.5)
    rate = here.displacement_at(LAYOUT.positions, by="tilt_deg")[-1]
    change = high.displacement_at(LAYOUT.positions)[-1] - low.displacement_at(LAYOUT.positions)[-1]
    # every press has a mesh of its own: points of the wall themselves differ by 0.08 here
    assert np.sqrt(np.mean((change - rate) ** 2)) < 0.12 * np.sqrt(np.mean(change**2))


@pytest.mark.parametrize("name", ["thickness", "twist_rate_deg"])
def test_tips_on_both_sides_of_the_mirror_follow_a_derivative(presses: list[Press], name: str) -> None:
    """What turns about the axis moves mirrored tips to mirrored places the other way, all else the same way."""
    flip = np.array([-1.0, 1.0, 1.0])
    rate, mirrored = (
        presses[1].displacement_at(points, by=name)[-1] for points in (LAYOUT.positions, LAYOUT.positions * flip)
    )
    sign = -1 if name == "twist_rate_deg" else 1
    assert np.abs(rate).max() > 1e-3
    assert mirrored == pytest.approx(sign * rate * flip, abs=1e-9)
    on_mirror = np.abs(LAYOUT.positions[:, 0]) < 1e-9
    assert on_mirror.any()
    assert np.abs(rate[on_mirror][:, 1:] if sign < 0 else rate[on_mirror][:, 0]).max() < 1e-9


def test_a_press_has_no_derivative_by_the_length_of_pins() -> None:
    """The wall does not know of them; where tips go is linear in their length."""
    names = parameter_names(mesh_skin(SKIN, MeshSpec(cells=8)), ECOFLEX, WallSpec())
    assert "thickness" in names
    assert "pin" not in names


def test_a_mesh_of_pins_is_that_of_the_dome() -> None:
    mesh, bare = (
        mesh_skin(SKIN, MeshSpec(cells=8)),
        mesh_skin(DomeSpec(height=20, thickness=2).build(), MeshSpec(cells=8)),
    )
    assert mesh.nodes == pytest.approx(bare.nodes, abs=0)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"height": 25}, ("dome-bulges",)),
        ({"pin": 17}, ("pins-too-long",)),
        ({"height": 10, "pin": 9}, ("pins-too-long",)),
    ],
)
def test_pins_that_cannot_be_are_refused(change: dict[str, float], says: tuple[str, ...]) -> None:
    with refused(*says):
        SPEC.model_copy(update=change).build()


def test_points_of_the_wall_are_no_tips(mesh: Mesh) -> None:
    with refused("point-off-surface"):
        locate_inner(mesh, SKIN.wall.nearest(LAYOUT.positions))


def test_pins_are_read_from_a_file() -> None:
    assert skin_from_data(SKIN.spec_data).build() == PinnedDome(20, 20, 2, 3)
