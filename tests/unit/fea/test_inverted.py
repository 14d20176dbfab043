"""The inverted state: how it is found, and what is not called so."""

from dataclasses import replace

import numpy as np
import pytest

from errors import check_values
from palpate.design import DomeSpec, build_skin
from palpate.fea import BallSpec, Branch, WallSpec
from palpate.fea.inverted import RING_POINTS, explain_rejection, find_contact_ring, mirror_displacement
from palpate.fea.solve_press import start_press
from palpate.material import get_material
from palpate.mechanics import EndReason, SolverSpec, State
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press

MATERIAL = get_material("zaid_2024_ecoflex_00_30")
DEPTH = 4.0


def skin(thickness: float = 1.0, cells: int = 8):
    return mesh_skin(build_skin(DomeSpec(height=20, thickness=thickness)), MeshSpec(cells=cells))


@pytest.fixture(scope="module")
def press():
    return solve_press(skin(), MATERIAL, WallSpec(contact="frictionless", depth=DEPTH), branch=Branch.INVERTED)


@pytest.fixture(scope="module")
def path(press):
    """A path under the wall of `press`, whose monitor judges states."""
    return start_press(press.mesh, MATERIAL, press.obstacle, SolverSpec(), RING_POINTS)


def judged(path, displacement, negative_pivots: int = 0) -> str:
    rest = path.increments[0]
    state = State(displacement, rest.state.p)
    return explain_rejection(path.monitor, replace(rest, depth=DEPTH, state=state, negative_pivots=negative_pivots))


def test_the_branch_reaches_from_its_onset_to_the_full_depth(press) -> None:
    assert press.ended is EndReason.DEPTH_REACHED
    assert press.depth[0] == pytest.approx(2.65, abs=0.1)
    assert press.depth[-1] == DEPTH
    assert (press.branch == Branch.INVERTED).all()
    assert (press.negative_pivots == 0).all()


def test_its_apex_is_off_the_wall_by_nearly_the_depth_and_its_energy_is_the_work(press) -> None:
    assert 0.6 * DEPTH < press.apex_gap[-1] < DEPTH
    stored = press.energy + press.contact_energy
    assert stored[-1] - stored[0] == pytest.approx(press.work[-1] - press.work[0], rel=0.03)


def test_the_mirrored_skin_keeps_its_order_and_nearly_its_volume(path, press) -> None:
    moved = mirror_displacement(press.mesh, path.loading.obstacle(DEPTH))
    skin = press.mesh.nodes + moved
    assert np.isfinite(path.problem.assemble(State(moved, path.increments[0].state.p), ()).elastic)
    apex_inner, apex_outer = skin[press.mesh.pole_inner], skin[press.mesh.pole_outer]
    assert apex_outer[2] - apex_inner[2] == pytest.approx(1.0, rel=0.02)
    assert np.abs(moved[press.mesh.base]).max() == 0


def test_the_inverted_state_is_not_doubted_and_touches_on_a_ring(path, press) -> None:
    state = State(press.displacement[-1], path.increments[0].state.p)
    ring = find_contact_ring(path.monitor, DEPTH, state)
    assert judged(path, press.displacement[-1]) == ""
    assert 0.8 * ring.outer < ring.inner < ring.outer < np.sqrt(2 * 21 * DEPTH)


def test_an_unstable_state_is_not_called_inverted(path, press) -> None:
    check_values(judged(path, press.displacement[-1], negative_pivots=2), 2)


def test_the_flat_state_is_not_called_inverted(path, press) -> None:
    flat = solve_press(press.mesh, MATERIAL, press.obstacle)
    assert (flat.branch == Branch.FLAT).all()
    check_values(judged(path, flat.displacement[-1]), "4 mm")


def test_a_dented_state_is_not_called_inverted(path, press) -> None:
    flat = solve_press(press.mesh, MATERIAL, press.obstacle)
    dented = path.monitor.perturbed(DEPTH, State(flat.displacement[-1], path.increments[0].state.p), 1.5)
    assert "ring" in judged(path, dented)


def test_a_half_lifted_state_is_not_called_inverted(path, press) -> None:
    flat = solve_press(press.mesh, MATERIAL, press.obstacle).displacement[-1]
    lifted = np.where(press.mesh.nodes[:, 1:2] > -2.0, press.displacement[-1], flat)
    assert "ring" in judged(path, lifted)


def test_a_state_without_contact_is_not_called_inverted(path, press) -> None:
    sunk = press.displacement[-1] - [0.0, 0.0, 1.0]
    assert judged(path, sunk) != ""


def test_it_is_the_same_under_any_contact_law(press) -> None:
    wall = WallSpec(contact="no-slip", depth=DEPTH)
    sticking = solve_press(skin(), MATERIAL, wall, branch=Branch.INVERTED)
    assert sticking.depth == pytest.approx(press.depth)
    assert sticking.energy == pytest.approx(press.energy, rel=1e-6)


def test_it_rests_where_it_is_when_contact_sticks(press) -> None:
    path = start_press(press.mesh, MATERIAL, WallSpec(contact="no-slip", depth=DEPTH), SolverSpec(), RING_POINTS)
    shape = press.displacement[-1]
    path.release()
    assert path.settle(DEPTH, shape, State(shape, path.increments[0].state.p))
    before = path.last
    assert path.advance(DEPTH + 0.01)
    assert path.monitor.gap(path.last.depth, path.last.state) == pytest.approx(
        path.monitor.gap(DEPTH, before.state), abs=0.05
    )
    assert path.last.negative_pivots == 0


def test_a_thick_dome_has_none_and_says_why() -> None:
    press = solve_press(skin(4), MATERIAL, WallSpec(contact="frictionless", depth=2.4), branch=Branch.INVERTED)
    assert press.ended is EndReason.NO_BRANCH
    check_values(press.message, "2.4 mm")


def test_under_a_ball_the_skin_is_mirrored_in_the_ball() -> None:
    ball = BallSpec(radius=60, depth=DEPTH, contact="frictionless")
    press = solve_press(skin(), MATERIAL, ball, branch=Branch.INVERTED)
    assert press.ended in (EndReason.DEPTH_REACHED, EndReason.NO_BRANCH)
    assert (press.branch == Branch.INVERTED).all() or len(press.depth) == 1


@pytest.mark.parametrize("contact", ["frictionless", "no-slip"])
def test_without_adhesion_nothing_pulls_the_skin_to_the_wall(contact: str) -> None:
    cells = 12 if contact == "frictionless" else 8  # on a coarse one it jumps too early
    press = solve_press(skin(cells=cells), MATERIAL, WallSpec(contact=contact, depth=DEPTH), SolverSpec(adhesion=0))
    assert press.ended is EndReason.DEPTH_REACHED
    assert (press.stabilisation_tension == 0).all()
    if contact == "frictionless":
        assert press.branch[-1] == Branch.INVERTED
        assert press.jump_depth > 2.6


def test_its_derivatives_are_differences_of_two_presses() -> None:
    """By thickness, of domes a hundredth thicker and thinner; nothing changes as the wall slides along itself."""
    wall, names = WallSpec(tilt_deg=6.0, contact=0.5, depth=DEPTH), ("thickness", "lateral_rate")
    press, thicker, thinner = (
        solve_press(skin(thickness, 10), MATERIAL, wall, SolverSpec(derivatives=asked), Branch.INVERTED)
        for thickness, asked in ((1.0, names), (1.01, ()), (0.99, ()))
    )
    found = press.derivative("thickness")
    for image in (-2, -1):
        difference = (thicker.displacement[image] - thinner.displacement[image]) / 0.02
        assert np.linalg.norm(found.displacement[image] - difference) < 0.01 * np.linalg.norm(difference)
        assert found.force[image, 2] == pytest.approx(
            (thicker.force[image, 2] - thinner.force[image, 2]) / 0.02, rel=0.01
        )
    assert np.abs(press.derivative("lateral_rate").displacement).max() < 1e-5
