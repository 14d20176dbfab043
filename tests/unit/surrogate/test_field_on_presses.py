"""The marker field of solved presses against presses solved for the pose itself, on a coarse mesh."""

import numpy as np
import pytest

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, rotation_vector
from palpate.fea import WallSpec
from palpate.fea.plate import PlateSpec
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import build_field
from presses import solve_press

DEPTH = 3.2
DOME = build_skin(DomeSpec(height=20, thickness=3))
LAYOUT = place_markers(DOME, MarkerSpec(count=37))


def press(tilt_deg, azimuth_deg=0.0, spec=WallSpec, **obstacle):
    placed = spec(tilt_deg=tilt_deg, azimuth_deg=azimuth_deg, depth=DEPTH, **obstacle)
    mesh = mesh_skin(DOME, MeshSpec(cells=8, whole=not placed.mirrored))
    return solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), placed, SolverSpec(edge_share=1.0))


@pytest.fixture(scope="module")
def field():
    return build_field([press(tilt) for tilt in (0.0, 2.0, 4.0, 6.0)], LAYOUT)


@pytest.mark.parametrize(("tilt", "azimuth"), [(3.0, 40.0), (5.0, -100.0)])
def test_a_tilt_between_two_presses_and_another_azimuth_agree_with_the_direct_solution(field, tilt, azimuth):
    direct = press(tilt, azimuth).positions(LAYOUT.positions)[-1]
    rx, ry = tilt * np.cos(np.deg2rad([azimuth])), tilt * np.sin(np.deg2rad([azimuth]))
    found = field.positions(rx, ry, 3)[0]
    assert np.linalg.norm(found - direct, axis=1).max() < 0.005 * DEPTH


@pytest.mark.parametrize("off", [{"offset": 4.0}, pytest.param({"offset_across": 3.0}, marks=pytest.mark.slow)])
def test_a_hole_off_the_axis_turns_with_the_tilt_and_ends_at_the_untilted_press(off, monkeypatch):
    hole = {"spec": PlateSpec, "hole_diameter": 5.0, "edge_radius": 1.0, **off}
    presses = [press(tilt, **hole) for tilt in (0.0, 2.0, 4.0, 6.0)]
    turned = [press(1.0, azimuth, **hole).positions(LAYOUT.positions)[-1] for azimuth in (0.0, 70.0)]
    at = rotation_vector(1.0, np.radians([0.0, 70.0]))

    def apart():
        found = build_field(presses, LAYOUT).positions(at[:, 0], at[:, 1], 3)
        return np.linalg.norm(found - turned, axis=2).max(axis=1)

    ended = apart()
    monkeypatch.setattr(PlateSpec, "centred", True)
    assert ended[0] < 0.01 * DEPTH
    assert ended[1] < 0.02 * DEPTH  # the cells of a whole mesh do not turn with the hole
    assert apart()[0] > 1.1 * ended[0]
