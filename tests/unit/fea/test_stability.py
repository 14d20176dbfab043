"""Both stable states of a dome."""

import numpy as np
import pytest

from palpate.design import DomeSpec, build_skin
from palpate.fea import Branch, WallSpec, find_stability
from palpate.material import get_material
from palpate.mechanics import EndReason
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press

MATERIAL = get_material("zaid_2024_ecoflex_00_30")


def coarse(thickness: float):
    return mesh_skin(build_skin(DomeSpec(height=20, thickness=thickness)), MeshSpec(cells=10))


@pytest.mark.slow
def test_a_thin_dome_has_a_second_state_from_some_2_6_thicknesses_on() -> None:
    found = find_stability(coarse(1), MATERIAL, WallSpec(contact="frictionless", depth=4.0))
    assert 2.2 < found.inverted_from < 3.4
    assert np.isnan(found.flat_to)
    assert found.inverted_energy[-1] < found.flat_energy[-1]
    assert np.isnan(found.inverted_energy[found.depth < found.inverted_from - 1e-6]).all()


@pytest.mark.slow(40)
def test_where_a_flat_dome_becomes_unstable_it_jumps_to_the_inverted_state() -> None:
    mesh = mesh_skin(build_skin(DomeSpec(height=10, thickness=1)), MeshSpec(cells=14))
    press = solve_press(mesh, MATERIAL, WallSpec(tilt_deg=12, contact="frictionless", depth=6.6, depth_step=0.2))
    assert press.ended is EndReason.DEPTH_REACHED, press.message
    assert 6.0 < press.jump_depth < 6.6
    after = press.depth >= press.jump_depth
    assert (press.branch[after] == Branch.INVERTED).all()
    assert (press.branch[~after] == Branch.FLAT).all()
    assert press.energy[after][0] < 0.7 * press.energy[~after][-1]


@pytest.mark.parametrize("contact", ["frictionless", "no-slip"])
def test_unloading_goes_back_through_the_same_images(contact: str) -> None:
    wall = WallSpec(contact=contact, depth=2.4, tilt_deg=5, unload=True)
    press = solve_press(coarse(3), MATERIAL, wall)
    assert press.depth == pytest.approx([0, 0.8, 1.6, 2.4, 1.6, 0.8, 0])
    assert press.energy[4] == pytest.approx(press.energy[2], rel=0.01)
    assert press.energy[-1] == pytest.approx(0, abs=1e-3)
    assert press.work[-1] == pytest.approx(0, abs=0.03 * press.work[3])


def test_what_friction_takes_is_the_work_that_is_not_stored() -> None:
    press = solve_press(coarse(3), MATERIAL, WallSpec(contact=0.3, depth=3.2, tilt_deg=5))
    stored = press.energy + press.contact_energy
    assert press.dissipation[-1] > 0.005 * press.work[-1]
    assert press.work[-1] == pytest.approx(stored[-1] + press.dissipation[-1], rel=3e-3)
