"""Fields of barrels between the tilts that were pressed, what is made of them, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from errors import refused
from palpate.camera import Camera, build_camera
from palpate.datasets import DatasetSpec, generate_dataset
from palpate.design import MarkerSpec, place_markers, rotation_vector
from palpate.design.barrel import BarrelSpec
from palpate.fea import Press
from palpate.fea.side_wall import SideWallSpec
from palpate.learn import compute_error_bounds
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, locate_inner, mesh_skin
from palpate.study import read_study
from palpate.surrogate import PressField, build_field, build_twin
from palpate.viewer.pressed_skin import build_pressed_skin
from presses import solve_press

SKIN = BarrelSpec().build()
LAYOUT = place_markers(SKIN, MarkerSpec(rows=8, around=12, pitch=28))
TILTS = (87.0, 88.5, 90.0, 91.5, 93.0)


def press(tilt_deg: float, depth: float = 3.0) -> Press:
    wall = SideWallSpec(tilt_deg=tilt_deg, depth=depth, depth_step=1.0, contact="frictionless")
    mesh = mesh_skin(SKIN, MeshSpec(cells=8, core=2))
    silicone = get_material("neo-hooke:0.02176").with_bulk_ratio(9.667)
    return solve_press(mesh, silicone, wall, SolverSpec(tolerance=1e-6))


@pytest.fixture(scope="module")
def presses() -> list[Press]:
    return [press(tilt) for tilt in TILTS]


@pytest.fixture(scope="module")
def field(presses: list[Press]) -> PressField:
    return build_field(presses, LAYOUT)


@pytest.fixture(scope="module")
def camera() -> Camera:
    return build_camera(read_study("barrel").camera)


def test_markers_between_the_tilts_are_those_of_a_press_there_turned_to_the_azimuth(field: PressField) -> None:
    tilt, azimuth = 89.3, 40.0
    solved = press(tilt)
    solved = replace(solved, obstacle=solved.obstacle.model_copy(update={"azimuth_deg": azimuth}))
    rx, ry = rotation_vector(np.array([tilt]), np.radians(azimuth)).T
    for image in range(3):
        truth = solved.positions(LAYOUT.positions)[image + 1]
        error = np.linalg.norm(field.positions(rx, ry, image)[0] - truth, axis=1)
        moved = np.linalg.norm(truth - LAYOUT.positions, axis=1)
        assert np.sqrt((error**2).mean()) < 0.03 * np.sqrt((moved**2).mean())
        # a control: two degrees are 18 mm along the axis
        other = field.positions(*rotation_vector(np.array([tilt + 2]), np.radians(azimuth)).T, image)
        assert np.linalg.norm(other[0] - truth, axis=1).max() > 5 * error.max()


def test_fields_of_the_side_have_a_least_tilt_and_no_answer_below_it(field: PressField) -> None:
    assert (field.min_tilt_deg, field.max_offset) == (87.0, 93.0)
    branch, reason = field.labels(np.array([86.0, 87.0, 90.2, 94.0]), 0)
    assert list(branch) == ["", "flat", "flat", ""]
    assert (reason[0], reason[3]) == ("below the solved tilts", "beyond the solved tilts")


def test_poses_of_a_dataset_fill_the_ring_of_tilts_evenly(presses: list[Press], camera: Camera) -> None:
    spec = DatasetSpec(n_presses=400, dropped_images=1)
    dataset = generate_dataset(presses, LAYOUT, camera, spec)
    assert not dataset.dropped
    assert len(dataset.poses) == 2 * 400
    tilt, azimuth = np.hypot(*dataset.poses[:, :2].T), np.arctan2(dataset.poses[:, 1], dataset.poses[:, 0])
    assert 87.0 <= tilt.min() < 87.2
    assert 92.8 < tilt.max() <= 93.0
    assert np.median(tilt) == pytest.approx(90.0, abs=0.3)
    assert np.abs(np.exp(1j * azimuth).mean()) < 0.02
    moved = np.linalg.norm(dataset.images_px[dataset.poses[:, 2] == 3.0] - dataset.rest_px, axis=-1)
    assert moved.max(axis=1).min() > 3.0


def test_limits_are_told_of_poses_in_the_ring(field: PressField, camera: Camera) -> None:
    limits = compute_error_bounds(field, camera, DatasetSpec(dropped_images=1, jitter_px=1.0))
    assert [limit.depth_mm for limit in limits] == [2.0, 3.0]
    assert all(limit.share == 1.0 and limit.poses > 30 for limit in limits)
    assert limits[1].least_squares_deg < limits[0].least_squares_deg < 10.0
    assert all(limit.floor_deg < limit.least_squares_deg for limit in limits)


def test_drawn_presses_carry_their_markers_and_do_not_pass_the_wall(presses: list[Press]) -> None:
    drawn = build_pressed_skin(presses)
    motion = drawn.at(90.75)
    assert motion.depths_mm.tolist() == pytest.approx([0.0, 1.0, 2.0, 3.0])
    assert motion.way == pytest.approx(motion.normal)
    assert motion.touch @ motion.normal == pytest.approx(SKIN.support_point(motion.normal) @ motion.normal)
    ahead = LAYOUT.positions[:, 0] >= 0
    surface = locate_inner(drawn.mesh, LAYOUT.positions[ahead]).interpolate(motion.displacement)
    seen = drawn.positions(LAYOUT, motion, 0.0)[:, ahead] - LAYOUT.positions[ahead]
    moved = np.linalg.norm(seen, axis=-1)
    assert np.linalg.norm(surface - seen, axis=-1).max() < 0.15 * moved.max()  # ten coarse cells, fewer at the wall
    outer = (
        drawn.mesh.nodes[np.unique(drawn.mesh.outer_faces)]
        + motion.displacement[:, np.unique(drawn.mesh.outer_faces)]
    )
    beyond = (outer - motion.touch) @ motion.normal + motion.depths_mm[:, None]
    assert beyond.max() < 0.4  # of 3 mm; at rest no point is beyond the place of first touch
    assert beyond[0].max() == pytest.approx(0.0, abs=0.1)


def test_the_press_drawn_at_one_end_is_the_mirror_image_of_that_at_the_other(presses: list[Press]) -> None:
    drawn = build_pressed_skin(presses)
    one, other = drawn.at(88.0), drawn.at(92.0)
    _, across = cKDTree(drawn.nodes).query([0.0, 0.0, 260.0] + drawn.nodes * [1.0, 1.0, -1.0])
    assert other.displacement == pytest.approx(one.displacement[:, across] * [1.0, 1.0, -1.0], abs=2e-3)
    assert other.force_n == pytest.approx(one.force_n, rel=1e-3)


def test_forces_and_twins_are_refused(presses: list[Press], camera: Camera) -> None:
    with refused("skin-no-apex"):
        generate_dataset(presses, LAYOUT, camera, DatasetSpec(n_presses=10, dropped_images=1), forces=True)
    with refused("skin-no-apex"):
        build_twin(presses)
