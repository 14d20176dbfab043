"""The marker field of solved presses against presses solved for the pose itself, on a coarse mesh."""

import numpy as np
import pytest

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import build_field
from presses import solve_press

DEPTH = 3.2
DOME = build_skin(DomeSpec(height=20, thickness=3))
LAYOUT = place_markers(DOME, MarkerSpec(count=37))


def press(tilt_deg, azimuth_deg=0.0):
    mesh = mesh_skin(DOME, MeshSpec(cells=8))
    wall = WallSpec(tilt_deg=tilt_deg, azimuth_deg=azimuth_deg, depth=DEPTH)
    return solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), wall)


@pytest.fixture(scope="module")
def field():
    return build_field([press(tilt) for tilt in (0.0, 2.0, 4.0, 6.0)], LAYOUT)


@pytest.mark.parametrize(("tilt", "azimuth"), [(3.0, 40.0), (5.0, -100.0)])
def test_a_tilt_between_two_presses_and_another_azimuth_agree_with_the_direct_solution(field, tilt, azimuth):
    direct = press(tilt, azimuth).positions(LAYOUT.positions)[-1]
    rx, ry = tilt * np.cos(np.deg2rad([azimuth])), tilt * np.sin(np.deg2rad([azimuth]))
    found = field.positions(rx, ry, 3)[0]
    assert np.linalg.norm(found - direct, axis=1).max() < 0.005 * DEPTH
