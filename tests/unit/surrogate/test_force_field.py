"""Forces between solved presses, against a press solved for the pose itself."""

import numpy as np
import pytest

from palpate.design import DomeSpec, build_skin
from palpate.fea import Press, WallSpec
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import PressField, build_field
from presses import solve_press

DOME = build_skin(DomeSpec(height=20, thickness=3))


def press(tilt_deg: float, azimuth_deg: float = 0.0) -> Press:
    wall = WallSpec(tilt_deg=tilt_deg, azimuth_deg=azimuth_deg, depth=2.4)
    return solve_press(mesh_skin(DOME, MeshSpec(cells=8)), get_material("zaid_2024_ecoflex_00_30"), wall)


@pytest.fixture(scope="module")
def field() -> PressField:
    return build_field([press(tilt) for tilt in (0.0, 3.0, 6.0, 9.0)])


@pytest.mark.parametrize(("tilt", "azimuth"), [(4.5, 40.0), (7.5, -100.0)])
def test_a_wall_between_two_presses_bears_what_the_direct_solution_says(field, tilt, azimuth) -> None:
    turn = np.radians([azimuth])
    found = field.forces(tilt * np.cos(turn), tilt * np.sin(turn), 2)[0]
    assert found == pytest.approx(press(tilt, azimuth).force[-1], abs=0.005 * np.linalg.norm(found))


def test_a_wall_tilted_the_other_way_bears_the_same_turned(field) -> None:
    here, there = field.forces(np.array([2.0, -2.0]), np.array([1.0, -1.0]), 1)
    assert there == pytest.approx(here * [-1.0, -1.0, 1.0])
    assert np.isnan(field.forces(np.array([20.0]), np.array([0.0]), 1)).all()
