from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from errors import refused
from kinematic_press import PinholeCamera, kinematic_positions, rings, solved
from needs import needs
from palpate.datasets import (
    DatasetSpec,
    check_leakage,
    draw_jitter,
    generate_dataset,
    read_dataset,
    sample_poses,
    write_dataset,
)
from palpate.datasets.generate_dataset import _refuse_forces
from palpate.design import OFFSET_SPACE

LAYOUT, CAMERA = rings(), PinholeCamera()
SMALL = DatasetSpec(n_presses=60)


@pytest.fixture(scope="module")
def dataset():
    return generate_dataset(solved(), LAYOUT, CAMERA, SMALL)


def test_every_press_gives_the_images_from_2_4_to_8_mm(dataset):
    assert dataset.images_px.shape == (60 * 8, 37, 2)
    assert np.allclose(np.unique(dataset.poses[:, 2].round(9)), np.arange(2.4, 8.1, 0.8))
    assert (np.bincount(dataset.press) == 8).all()
    assert dataset.dropped == {}


def test_images_are_the_projected_markers_of_their_pose(dataset):
    rx, ry, depth = dataset.poses[100]
    expected = CAMERA.project(kinematic_positions(LAYOUT.positions, rx, ry, depth))
    assert np.abs(dataset.images_px[100] - expected).max() < 1e-4


def test_travel_is_the_mean_distance_from_rest(dataset):
    rx, ry, depth = dataset.poses[-1]
    moved = kinematic_positions(LAYOUT.positions, rx, ry, depth) - LAYOUT.positions
    assert dataset.travel_mm[-1] == pytest.approx(np.linalg.norm(moved, axis=1).mean(), rel=1e-5)
    deepest = dataset.poses[:, 2] > 7.99
    assert dataset.full_depth_travel_mm() == pytest.approx(dataset.travel_mm[deepest].mean())


def test_disc_is_filled_evenly_by_area():
    tilt = np.hypot(*sample_poses(DatasetSpec(n_presses=4000)).T)
    share = [(tilt <= 12 * np.sqrt(area)).mean() for area in (0.1, 0.25, 0.5, 0.75)]
    assert np.allclose(share, [0.1, 0.25, 0.5, 0.75], atol=0.005)


def test_another_seed_gives_other_poses_and_the_same_seed_the_same():
    one, again, other = (sample_poses(DatasetSpec(seed=seed)) for seed in (3, 3, 4))
    assert np.array_equal(one, again)
    assert np.abs(one - other).max() > 1.0


@pytest.mark.parametrize(("protocol", "poses", "distinct"), [("paper-91", 91, 79), ("paper-504", 504, 433)])
def test_protocols_of_the_paper_repeat_the_straight_press(protocol, poses, distinct):
    spec = DatasetSpec(poses=protocol)
    assert sample_poses(spec).shape == (poses, 2)
    dataset = generate_dataset(solved(), LAYOUT, CAMERA, spec)
    assert dataset.images_px.shape[0] == poses * 8
    assert dataset.virtual_presses == distinct


def test_held_out_presses_are_whole_and_a_fifth(dataset):
    held_out = set(dataset.press[dataset.validation])
    assert len(held_out) == 12
    assert held_out.isdisjoint(dataset.press[~dataset.validation])


def test_a_press_on_both_sides_is_refused(dataset):
    leaking = dataset.validation.copy()
    leaking[np.flatnonzero(leaking)[0]] = False
    with refused("split-shares-press"):
        replace(dataset, validation=leaking)


def test_one_pose_under_two_numbers_on_both_sides_is_refused():
    poses = np.array([[1.0, 2.0, 2.4], [1.0, 2.0, 2.4]])
    with refused("split-shares-pose", "1.000", "2.000"):
        check_leakage(np.array([0, 1]), poses, np.array([True, False]))


def test_images_out_of_reach_are_counted_by_reason():
    presses = [*solved(range(0, 9, 2)), *solved((10, 12), reached=7.1, ended="wall reached the clamped rim")]
    dataset = generate_dataset(presses, LAYOUT, CAMERA, SMALL)
    beyond = int((np.hypot(*sample_poses(SMALL).T) > 8).sum())
    assert dataset.dropped == {"wall reached the clamped rim": 2 * beyond}  # of 7.2 and 8.0 mm
    assert len(dataset.images_px) == 60 * 8 - 2 * beyond


def test_branches_are_labelled_image_by_image():
    presses = [*solved(range(0, 7, 2)), *solved(range(8, 13, 2), inverted_from=4.0)]
    dataset = generate_dataset(presses, LAYOUT, CAMERA, SMALL)
    inverted = dataset.branch == "inverted"
    assert (np.hypot(*dataset.poses[inverted, :2].T) >= 8).all()
    assert (dataset.poses[inverted, 2] >= 4).all()
    assert set(dataset.branch) == {"flat", "inverted"}
    assert dataset.dropped["between the flat and the inverted branch"] > 0


def test_an_image_with_a_marker_outside_is_left_out_and_counted():
    camera = PinholeCamera()
    camera.width_px = 251  # at rest the outer ring ends at u = 247.8 px
    dataset = generate_dataset(solved(), LAYOUT, camera, SMALL)
    assert dataset.dropped["a marker out of sight"] == 60 * 8 - len(dataset.images_px) > 0
    assert (dataset.images_px[..., 0] < camera.width_px).all()


def test_a_layout_that_does_not_fit_the_image_at_rest_is_refused():
    camera = PinholeCamera()
    camera.width_px = 200
    with refused("markers-hidden", "37"):
        generate_dataset(solved(), LAYOUT, camera, SMALL)


def test_presses_without_an_image_left_are_refused():
    with refused("dataset-no-image"):
        generate_dataset(solved(reached=1.6), LAYOUT, CAMERA, SMALL)


def test_jitter_is_uniform_in_pixels_and_each_coordinate_its_own():
    clean = np.full((400, 37, 2), 100.0)
    noise = draw_jitter(clean, 2.0, np.random.default_rng(0)) - clean
    assert np.abs(noise).max() <= 2.0
    assert noise.std() == pytest.approx(2 / np.sqrt(3), rel=0.01)
    assert abs(np.corrcoef(noise[..., 0].ravel(), noise[..., 1].ravel())[0, 1]) < 0.03


@pytest.mark.parametrize(("kind", "corner", "middle"), [("centred", -1.0, 0.0), ("unit", 0.0, 0.5)])
def test_normalisation_puts_the_image_where_it_says(kind, corner, middle):
    dataset = generate_dataset(solved(), LAYOUT, CAMERA, SMALL.model_copy(update={"normalisation": kind}))
    places = np.array([[0.0, 0.0], [173.0, 130.0], [346.0, 260.0]])
    assert np.allclose(dataset.normalisation.apply(places), np.array([[corner] * 2, [middle] * 2, [1.0] * 2]))


def test_file_gives_the_same_dataset_back(dataset, tmp_path):
    path = tmp_path / "dataset.h5"
    write_dataset(path, dataset)
    again = read_dataset(path)
    for name in ("images_px", "poses", "press", "validation", "branch", "travel_mm", "rest_px"):
        assert np.array_equal(getattr(again, name), getattr(dataset, name)), name
    assert (again.spec, again.image_size_px, again.solved_presses) == (SMALL, (346, 260), 7)


def test_xarray_opens_the_file_with_its_dimensions_and_units(dataset, tmp_path):
    xarray = needs("xarray")
    needs("h5netcdf")
    path = tmp_path / "dataset.h5"
    write_dataset(path, dataset)
    with xarray.open_dataset(path, engine="h5netcdf") as opened:
        assert dict(opened.sizes) == {"image": 480, "marker": 37, "pixel_axis": 2, "pose_axis": 3}
        assert opened.images_px.attrs["units"] == "px"
        depth = opened.poses.sel(pose_axis="depth_mm").values
        assert np.array_equal(depth, dataset.poses[:, 2])


def test_a_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "dataset.h5"
    path.write_bytes(b"not HDF5")
    with refused("dataset-unreadable"):
        read_dataset(path)


def test_a_file_of_another_version_is_refused(dataset, tmp_path):
    import h5py

    path = tmp_path / "dataset.h5"
    write_dataset(path, dataset)
    with h5py.File(path, "a") as file:
        file.attrs["palpate_dataset_version"] = "0"
    with refused("dataset-version", "0"):
        read_dataset(path)


def test_forces_of_an_obstacle_that_does_not_tilt_are_refused():
    ball = SimpleNamespace(obstacle=SimpleNamespace(pose_space=OFFSET_SPACE))
    with refused("forces-need-wall"):
        _refuse_forces([ball])
