"""A trained network tells the force on the wall beside the pose, and its pose stays what it was."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import onnx
import pytest

from errors import refused
from palpate.datasets import Dataset, DatasetSpec, sample_poses
from palpate.design import wall_normal
from palpate.learn import (
    calibrate_interval,
    fit_ridge,
    open_predictor,
    read_estimator,
    train_force_output,
    write_estimator,
)
from palpate.learn.force import FORCE_AXES, train_forces, turn_to_wall

DEPTHS = (2.0, 3.0, 4.0, 5.0)
PRESSES = 400


def pushes(poses: np.ndarray) -> np.ndarray:
    """Forces in the wall's axes: they grow with depth, and slope drags."""
    normal = 0.02 * poses[:, 2] ** 1.5
    return np.column_stack([0.01 * poses[:, 1] * normal, -0.01 * poses[:, 0] * normal, normal])


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    spec = DatasetSpec(n_presses=PRESSES, jitter_px=0.1)
    flat = np.repeat(sample_poses(spec), len(DEPTHS), axis=0)
    poses = np.column_stack([flat, np.tile(DEPTHS, PRESSES)])
    rest = np.random.default_rng(0).uniform(100, 200, (12, 2))
    moved = poses @ (np.random.default_rng(1).normal(0, 3.0, (3, 24)) * [[1.0], [1.0], [4.0]])
    press = np.repeat(np.arange(PRESSES), len(DEPTHS))
    return Dataset(
        spec=spec,
        images_px=rest + moved.reshape(-1, 12, 2),
        poses=poses,
        press=press,
        validation=press % 3 == 0,
        branch=np.full(len(press), "flat"),
        travel_mm=np.full(len(press), 1.0),
        rest_px=rest,
        image_size_px=(346, 260),
        solved_presses=1,
        dropped={},
        forces=turn_to_wall(pushes(poses), -poses),  # back to the axes of the skin
    )


@pytest.fixture(scope="module")
def files(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """An estimator, and the same with forces."""
    plain, told = (tmp_path_factory.mktemp("forces") / name for name in ("plain.onnx", "told.onnx"))
    write_estimator(plain, calibrate_interval(fit_ridge(dataset), dataset))
    train_force_output(plain, dataset, told)
    return plain, told


def test_the_axes_of_the_wall_are_the_dome_s_turned() -> None:
    poses = np.array([[3.0, -4.0, 5.0], [0.0, 0.0, 1.0]])
    normals = np.array([wall_normal(*np.radians(pose[:2])) for pose in poses])
    assert turn_to_wall(normals, poses) == pytest.approx(np.tile([0.0, 0.0, 1.0], (2, 1)), abs=1e-12)
    assert turn_to_wall(turn_to_wall(normals + 1.0, poses), -poses) == pytest.approx(normals + 1.0)


def test_forces_are_told_with_intervals_that_hold(dataset: Dataset, files: tuple[Path, Path]) -> None:
    held = dataset.subset(validation=True)
    found = open_predictor(files[1]).predict(held.images_px)
    assert found.forces is not None
    assert found.forces_half_width is not None
    off = found.forces - pushes(held.poses)
    assert np.sqrt(np.mean(off[:, 2] ** 2)) < 0.02 * pushes(held.poses)[:, 2].max()
    assert np.mean(np.abs(off) <= found.forces_half_width) > 0.85
    assert (found.forces_half_width > 0).all()


def test_the_pose_of_a_file_with_forces_is_what_it_was(dataset: Dataset, files: tuple[Path, Path]) -> None:
    plain, told = (open_predictor(path).predict(dataset.images_px) for path in files)
    assert plain.forces is None
    for name in ("pose", "half_width", "out_of_distribution"):
        assert np.array_equal(getattr(plain, name), getattr(told, name))
    assert np.array_equal(read_estimator(files[1]).weights[0], read_estimator(files[0]).weights[0])


def test_the_file_says_what_its_forces_are_worth(dataset: Dataset, files: tuple[Path, Path]) -> None:
    said = json.loads({e.key: e.value for e in onnx.load(files[1]).metadata_props}["forces"])
    assert said["outputs"] == list(FORCE_AXES)
    assert 0.8 < said["coverage"] <= 1.0
    assert said["clean_normal_rmse_n"] < said["normal_rmse_n"] < 0.03 * said["normal_rms_n"]
    head = train_forces(dataset)
    forces, half_width = head.predict(dataset.images_px)
    found = open_predictor(files[1]).predict(dataset.images_px)
    assert found.forces == pytest.approx(forces, abs=1e-5)
    assert found.forces_half_width == pytest.approx(half_width, rel=1e-4)


def test_images_without_forces_teach_none(dataset: Dataset) -> None:
    with refused("dataset-no-forces"):
        train_forces(replace(dataset, forces=None))


def test_intervals_of_forces_are_no_wider_than_their_errors_ask(dataset: Dataset, files: tuple[Path, Path]) -> None:
    """Of level 0.9: about the ninth decile of the errors, of every axis."""
    held = dataset.subset(validation=True)
    found = open_predictor(files[1]).predict(held.images_px)
    assert found.forces is not None
    assert found.forces_half_width is not None
    decile = np.quantile(np.abs(found.forces - pushes(held.poses)), 0.9, axis=0)
    ratio = np.median(found.forces_half_width, axis=0) / decile
    assert (ratio > 0.5).all()
    assert (ratio < 3.0).all()
