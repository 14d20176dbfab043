"""A plate with a hole: its geometry, its limits against a wall, and CalculiX as a second solver."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from errors import refused
from needs import needs_program
from palpate.core import PalpateError
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, obstacle_from_data, solve_press_calculix
from palpate.fea.plate import Plate, PlateSpec
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press

SILICONE = get_material("zaid_2024_ecoflex_00_30")
DOME = build_skin(DomeSpec(height=20, thickness=3))
HOLE, EDGE, SINK, HALF = 2.5, 0.4, 4.0, np.radians(50.0)


def sampled_profile(sunk: bool) -> np.ndarray:
    """Points (n, 2), r and h, of a fine grid inside the sharp profile, by at least the edge radius."""
    deep = (SINK - HOLE) / np.tan(HALF) if sunk else 0.0
    r, h = np.meshgrid(np.linspace(HOLE, 12.0, 951), np.linspace(0.0, 10.0, 1001), indexing="ij")
    far_in = [r - HOLE, h]
    if sunk:
        far_in.append((r - HOLE) * np.cos(HALF) + (h - deep) * np.sin(HALF))
    return np.column_stack([r.ravel(), h.ravel()])[np.min(far_in, axis=0).ravel() >= EDGE]


@pytest.mark.parametrize("sunk", [False, True])
def test_penetration_is_the_distance_from_a_sampled_body(sunk: bool) -> None:
    body = sampled_profile(sunk)
    plate = Plate(np.zeros(3), np.array([0.0, 0.0, 1.0]), HOLE, EDGE, SINK if sunk else HOLE, HALF)
    rng = np.random.default_rng(3)
    place = np.column_stack([rng.uniform(0.5, 7.0, 60), rng.uniform(-1.5, 4.0, 60)])
    turn = rng.uniform(0, 2 * np.pi, 60)
    points = np.column_stack([place[:, 0] * np.cos(turn), place[:, 0] * np.sin(turn), place[:, 1]])
    near = cKDTree(body).query(place)[0]
    outside = near > EDGE
    assert outside.sum() > 20
    assert plate.penetration(points)[outside] == pytest.approx(EDGE - near[outside], abs=0.015)
    assert (plate.penetration(points)[~outside] >= -0.015).all()


def test_a_tiny_hole_presses_like_a_wall_and_a_wide_one_does_not() -> None:
    mesh = mesh_skin(DOME, MeshSpec(cells=8, centred=False))
    travel = {"depth": 1.6, "depth_step": 0.8, "contact": "frictionless", "tilt_deg": 4.0}
    points = place_markers(DOME, MarkerSpec(count=37)).positions
    wall = solve_press(mesh, SILICONE, WallSpec(**travel))
    tiny, wide = (
        solve_press(mesh, SILICONE, PlateSpec(hole_diameter=size, edge_radius=edge, **travel))
        for size, edge in ((0.01, 0.01), (10.0, 0.5))
    )
    assert tiny.force[-1] == pytest.approx(wall.force[-1], rel=2e-3, abs=1e-6)
    assert tiny.positions(points) == pytest.approx(wall.positions(points), abs=2e-3)
    assert np.abs(wide.positions(points) - wall.positions(points)).max() > 0.1


@pytest.mark.slow
@needs_program("calculix-ccx")
@pytest.mark.parametrize(("sink", "cells", "core", "share"), [(0.0, 20, 5, 0.02), (11.0, 16, 3, 0.04)])
def test_calculix_agrees_over_facets(sink: float, cells: int, core: int, share: float) -> None:
    """CalculiX does not converge over the countersink with 20 cells; with 16, first contact is a narrow ring."""
    mesh = mesh_skin(DOME, MeshSpec(cells=cells, core=core, centred=False))
    plate = PlateSpec(
        tilt_deg=6, hole_diameter=8, edge_radius=0.5, sink_diameter=sink, depth=3.2, contact="frictionless"
    )
    ours, theirs = solve_press(mesh, SILICONE, plate), solve_press_calculix(mesh, SILICONE, plate)
    first = 2 if sink else 1
    assert theirs.force[first:, 2] == pytest.approx(ours.force[first:, 2], rel=share)
    points = place_markers(DOME, MarkerSpec(count=169)).positions
    assert np.linalg.norm(theirs.positions(points) - ours.positions(points), axis=-1).max() < share * 3.2


def test_a_countersink_must_contain_its_rounded_edges() -> None:
    for sink, edge in ((3.0, 0.1), (5.2, 2.0)):
        with pytest.raises(PalpateError) as caught:
            obstacle_from_data({"kind": "plate", "sink_diameter": sink, "edge_radius": edge})
        assert "countersink" in str(caught.value)
    assert obstacle_from_data({"kind": "plate", "sink_diameter": 8.0}) == PlateSpec(sink_diameter=8.0)


def test_a_hole_beside_the_plane_of_the_tilt_needs_a_whole_mesh() -> None:
    plate = PlateSpec(tilt_deg=4, hole_diameter=4, offset_across=1.5, depth=0.8, contact="frictionless")
    half, whole = (mesh_skin(DOME, MeshSpec(cells=6, whole=each)) for each in (False, True))
    with refused("mesh-whole-needed"):
        solve_press(half, SILICONE, plate)
    aside = solve_press(whole, SILICONE, plate)
    other = solve_press(whole, SILICONE, plate.model_copy(update={"offset_across": -1.5}))
    assert aside.force[-1] * [-1, 1, 1] == pytest.approx(other.force[-1], rel=1e-6, abs=1e-9)
    assert abs(aside.force[-1, 0]) > 1e-5


def test_a_hole_as_wide_as_the_skin_is_refused() -> None:
    with refused("obstacle-misses-skin"):
        PlateSpec(hole_diameter=50).check_skin(DOME)


def test_the_skin_over_a_hole_is_not_held_and_does_not_jump() -> None:
    """Below 1.5 thicknesses, points of the contact patch are held; those over a hole must be free."""
    plate = PlateSpec(tilt_deg=8, hole_diameter=4, depth=4.0, depth_step=1.0)
    thin = build_skin(DomeSpec(height=20, thickness=2))
    found = solve_press(mesh_skin(thin, MeshSpec(cells=6)), SILICONE, plate)
    assert np.isnan(found.jump_depth)
    assert set(found.branch) == {"flat"}


def test_a_plate_reaches_the_rim_earlier_by_as_much_as_the_skin_enters_the_hole() -> None:
    mesh = mesh_skin(DOME, MeshSpec(cells=6))
    flat, tiny, wide = (
        spec.clamp_depth(mesh)
        for spec in (
            WallSpec(),
            PlateSpec(hole_diameter=0.05, edge_radius=0.01),
            PlateSpec(hole_diameter=20, edge_radius=0.1),
        )
    )
    outer = DOME.outer_height
    radius = (outer**2 + DOME.outer_base_radius**2) / (2 * outer)
    assert tiny == pytest.approx(flat, abs=1e-3)
    assert flat - wide == pytest.approx(radius - np.sqrt(radius**2 - 10.0**2), abs=0.05)
