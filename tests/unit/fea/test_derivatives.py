"""Derivatives of a press against whole presses beside it, and against what symmetry and scaling demand."""

from dataclasses import replace

import numpy as np
import pytest

from errors import refused
from palpate.design import DomeSpec, build_skin
from palpate.fea import BallSpec, Press, WallSpec, read_press, write_press
from palpate.material import get_material, material_from_data
from palpate.mechanics import EndReason, SolverSpec
from palpate.mesh import Mesh, MeshSpec, centre_mesh, locate_inner, mesh_skin, reshape_mesh
from presses import solve_press

MATERIAL = get_material("zaid_2024_ecoflex_00_30")
SKIN = DomeSpec(height=20, thickness=2)
WALL = WallSpec(tilt_deg=5, depth=1.6, contact="frictionless")
SOLVER = SolverSpec(tolerance=1e-8)
STEPS = {
    "tilt_deg": 0.02,
    "depth": 0.01,
    "thickness": 0.005,
    "height": 0.02,
    "base_radius": 0.02,
    "C10": 1e-4,
    "curvature": 0.2,
}
NAMES = (*STEPS, "across_deg", "shift", "shift_across", "twist_deg")


def mesh_of(wall: WallSpec = WALL, cells: int = 10) -> Mesh:
    mesh = mesh_skin(build_skin(SKIN), MeshSpec(cells=cells))
    return centre_mesh(mesh, wall.at_first_contact(mesh)[1])


@pytest.fixture(scope="module")
def press() -> Press:
    return solve_press(mesh_of(), MATERIAL, WALL, SOLVER.model_copy(update={"derivatives": NAMES}))


@pytest.fixture(scope="module")
def stuck() -> Press:
    wall = WALL.model_copy(update={"contact": "no-slip"})
    return solve_press(mesh_of(), MATERIAL, wall, SOLVER.model_copy(update={"derivatives": NAMES}))


def beside(name: str, by: float) -> Press:
    """The whole press again, with a parameter that differs."""
    mesh, material, wall = mesh_of(), MATERIAL, WALL
    if name in ("tilt_deg", "depth", "curvature"):
        wall = wall.model_copy(update={name: getattr(wall, name) + by})
    elif name == "C10":
        data = material.key_data()
        constants = data["constants"] | {name: data["constants"][name] + by}
        material = material_from_data({"name": "other", **data, "constants": constants})
    else:
        mesh = reshape_mesh(mesh, build_skin(SKIN.model_copy(update={name: getattr(SKIN, name) + by})))
    return solve_press(mesh, material, wall, SOLVER)


@pytest.mark.parametrize("name", STEPS)
def test_a_derivative_is_the_difference_of_two_presses(press: Press, name: str) -> None:
    high, low = (beside(name, side * STEPS[name]) for side in (1, -1))
    found = press.derivative(name)
    difference = (high.displacement[-1] - low.displacement[-1]) / (2 * STEPS[name])
    scale = np.linalg.norm(difference) if name != "C10" else np.linalg.norm(press.displacement[-1]) / MATERIAL.law.C10
    assert np.linalg.norm(found.displacement[-1] - difference) < 2e-3 * scale
    force = (high.force[-1] - low.force[-1]) / (2 * STEPS[name])
    assert found.force[-1] == pytest.approx(force, abs=2e-3 * np.linalg.norm(force))


@pytest.mark.parametrize("kind", ["press", "stuck"])
def test_a_stiffer_silicone_of_the_same_shape_bears_as_much_more(kind: str, request: pytest.FixtureRequest) -> None:
    """All constants by one factor: the same shapes, and the force by that factor (Euler's theorem)."""
    press = request.getfixturevalue(kind)
    constants = MATERIAL.key_data()["constants"]
    solved = solve_press(
        press.mesh, MATERIAL, press.obstacle, SOLVER.model_copy(update={"derivatives": tuple(constants)})
    )
    total = sum(value * solved.derivative(name).force[-1] for name, value in constants.items())
    assert total == pytest.approx(solved.force[-1], rel=1e-4)
    moved = sum(value * solved.derivative(name).displacement[-1] for name, value in constants.items())
    assert np.abs(moved).max() < 1e-3 * np.abs(solved.displacement[-1]).max()


def test_across_the_tilt_the_force_turns_with_the_wall(press: Press) -> None:
    turned = np.cross([0, 0, 1], press.force[-1]) / WALL.tilt_deg
    assert press.derivative("across_deg").force[-1] == pytest.approx(turned, abs=1e-6 * press.force[-1, 2])


def test_a_frictionless_wall_may_slide_along_itself_and_twist(press: Press) -> None:
    assert np.abs(press.derivative("twist_deg").displacement[-1]).max() == 0
    normal = press.obstacle.normal(press.mesh)
    expected = -normal[1] / normal[2] * press.derivative("depth").displacement[-1]
    assert press.derivative("shift").displacement[-1] == pytest.approx(expected, abs=1e-6)


def test_what_sticks_is_dragged_along(stuck: Press) -> None:
    """A sideways travel meets a force against it, and the field is as far from the base as the patch is dragged."""
    for name, axis in (("shift", 1), ("shift_across", 0)):
        found = stuck.derivative(name)
        assert found.force[-1, axis] < -0.02
        assert np.abs(found.displacement[-1][:, axis]).max() == pytest.approx(1.0, abs=0.25)
        assert np.abs(found.displacement[-1][stuck.mesh.base]).max() == 0


@pytest.mark.parametrize(
    ("name", "by"), [("lateral_rate", 0.05), ("lateral_rate_across", 0.05), ("twist_rate_deg", 0.5)]
)
def test_a_wall_that_drifts_drags_what_sticks_to_it(name: str, by: float) -> None:
    """The derivative of half a model against whole models under walls that do drift, one and the other way."""
    wall = WALL.model_copy(update={"contact": "no-slip", "depth": 3.2})
    rate = solve_press(mesh_of(cells=5), MATERIAL, wall, SolverSpec(derivatives=(name,))).derivative(name)
    whole = mesh_skin(build_skin(SKIN), MeshSpec(cells=5, whole=True))
    high, low = (solve_press(whole, MATERIAL, wall.model_copy(update={name: side * by})) for side in (1, -1))
    places = build_skin(SKIN).inner_point(np.array([0.0, 2.0, 4.0, 6.0]), np.array([0.0, 0.5, 1.0, 1.4]))
    found = locate_inner(mesh_of(cells=5), places).interpolate(rate.displacement[-1])
    moved = (high.positions(places)[-1] - low.positions(places)[-1]) / (2 * by)
    assert np.linalg.norm(found - moved) < 0.05 * np.linalg.norm(moved)


def test_a_frictionless_wall_may_drift() -> None:
    rate = solve_press(mesh_of(), MATERIAL, WALL, SolverSpec(derivatives=("lateral_rate",))).derivative(
        "lateral_rate"
    )
    assert np.abs(rate.displacement).max() < 1e-6


@pytest.mark.parametrize("radius", [100.0, 1000.0])
def test_a_wall_of_one_curvature_is_a_large_ball(radius: float) -> None:
    """Bent walls and balls share no code but what asks them for their gap."""
    mesh, contact = mesh_of(WallSpec(), 5), {"depth": 1.6, "contact": 0.8}
    bent = solve_press(mesh, MATERIAL, WallSpec(curvature=1000 / radius, **contact))
    ball = solve_press(mesh, MATERIAL, BallSpec(radius=radius, **contact))
    flat = solve_press(mesh, MATERIAL, WallSpec(**contact))
    moved = np.linalg.norm(ball.displacement[-1] - flat.displacement[-1])
    assert np.linalg.norm(bent.displacement[-1] - ball.displacement[-1]) < 1e-3 * moved
    assert bent.force[-1, 2] == pytest.approx(ball.force[-1, 2], rel=1e-5)


def test_a_hollow_wall_touches_more_of_the_dome() -> None:
    forces = [
        solve_press(mesh_of(), MATERIAL, WALL.model_copy(update={"curvature": by})).force[-1, 2] for by in (-5, 0, 5)
    ]
    assert forces[0] > 1.05 * forces[1] > 1.1 * forces[2]


def test_half_a_model_cannot_drift_across_its_plane() -> None:
    with refused("mesh-whole-needed"):
        solve_press(mesh_of(), MATERIAL, WALL.model_copy(update={"lateral_rate_across": 0.1}))


def test_derivatives_survive_the_file(press: Press, tmp_path) -> None:
    write_press(tmp_path / "press.h5", press)
    again = read_press(tmp_path / "press.h5")
    for name in NAMES:
        assert again.derivative(name).across == press.derivative(name).across
        assert again.derivative(name).force == pytest.approx(press.derivative(name).force)
        assert again.derivative(name).displacement == pytest.approx(press.derivative(name).displacement, abs=1e-4)


def test_a_derivative_that_was_not_asked_for_is_refused(press: Press) -> None:
    with refused("derivative-not-solved", "friction"):
        press.derivative("friction")
    with refused("derivative-unknown", "friction"):
        solve_press(mesh_of(), MATERIAL, WALL, SolverSpec(derivatives=("friction",)))


def test_beyond_a_jump_there_is_no_derivative(press: Press) -> None:
    jumped = replace(press, jump_depth=1.2)
    assert jumped.derivative("depth", depth=0.8) is press.derivatives["depth"]
    with refused("derivative-beyond-jump", "1.2"):
        jumped.derivative("depth")


def test_on_the_way_back_every_increment_has_derivatives_of_its_own() -> None:
    """Without friction the way back goes through the same states; a wall that held on is left with a derivative."""
    solver = SOLVER.model_copy(update={"derivatives": ("tilt_deg", "depth")})
    left = {}
    for contact in ("frictionless", "no-slip"):
        wall = WALL.model_copy(update={"contact": contact, "unload": True, "depth_step": 0.8})
        force = solve_press(mesh_of(cells=5), MATERIAL, wall, solver).derivative("tilt_deg").force
        left[contact] = np.abs(force[4]).max()
        if contact == "frictionless":  # 3e-4 are the rounding of the differences, another on another processor
            assert np.abs(force[3] - force[1]).max() < 1e-3 * np.abs(force[1]).max()
    assert left["no-slip"] > 5 * left["frictionless"]


def test_where_a_press_broke_off_there_is_no_derivative(press: Press) -> None:
    broken = replace(press, ended=EndReason.NOT_CONVERGED, ended_depth=1.2)
    assert broken.derivative("depth", depth=1.19) is press.derivatives["depth"]
    for depth in (1.2, None):
        with refused("derivative-beyond-end", "1.2"):
            broken.derivative("depth", depth=depth)
    assert replace(broken, ended=EndReason.WALL_AT_CLAMP).derivative("depth") is press.derivatives["depth"]
