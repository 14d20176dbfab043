"""Splits by press, poses of presses and columns of a dataset: shares, limits and distributions."""

from dataclasses import replace

import numpy as np
import pytest

from errors import refused
from palpate.datasets import DatasetSpec
from palpate.datasets.dataset import Dataset
from palpate.datasets.poses import sample_poses
from palpate.datasets.split import SAME_POSE, check_leakage, number_presses, split_presses


@pytest.mark.parametrize(
    ("count", "validation", "test"), [(10, 0.2, 0.3), (3, 0.9, 0.05), (7, 0.5, 0.5), (5, 0.3, 0.0)]
)
def test_a_split_has_whole_presses_by_its_shares_and_one_of_each_use(
    count: int, validation: float, test: float
) -> None:
    press = np.repeat(np.arange(count), np.arange(1, count + 1))
    split = split_presses(press, 4, validation, test)
    parts = [set(press[mask]) for mask in (split.train, split.validation, split.test)]
    assert (split.train.astype(int) + split.validation + split.test).tolist() == [1] * len(press)
    assert not (parts[0] & parts[1]) | (parts[0] & parts[2]) | (parts[1] & parts[2])
    sizes = [len(part) for part in parts]
    tested = max(1, min(round(test * count), count - 2)) if test else 0
    held = max(1, min(round(validation * count), count - tested - 1))
    assert sizes == [count - tested - held, held, tested]
    assert split_presses(press, 4, validation, test).train.tolist() == split.train.tolist()
    assert any(
        split_presses(press, seed, validation, test).train.tolist() != split.train.tolist() for seed in (5, 6, 7)
    )


def test_presses_must_outnumber_their_uses() -> None:
    assert split_presses(np.array([0, 1]), 0, 0.5).validation.sum() == 1
    assert split_presses(np.array([0, 1, 2]), 0, 0.3, 0.3).test.sum() == 1
    for press, shares in (([0, 0], (0.5, 0.0)), ([0, 1, 1], (0.3, 0.3))):
        with refused("split-few-presses", len(set(press))):
            split_presses(np.array(press), 0, *shares)


def test_presses_are_numbered_as_they_come_and_equal_places_are_one() -> None:
    places = np.array([[3.0, 1.0], [1.0, 2.0], [3.0, 1.0 + 0.4 * SAME_POSE], [0.0, 0.0], [1.0, 2.0 + 2 * SAME_POSE]])
    assert number_presses(places).tolist() == [0, 1, 0, 2, 3]


def test_a_press_or_a_pose_on_both_sides_is_refused_by_its_place() -> None:
    poses, validation = np.array([[1.0, 2.0, 3.0], [1.0, 5.0, 3.0], [4.0, 2.0, 3.0]]), np.array([True, False, False])
    check_leakage(np.array([0, 1, 2]), poses, validation)
    with refused("split-shares-press", 0):
        check_leakage(np.array([0, 1, 0]), poses, validation)
    poses[2, :2] = (1.0, 2.0)
    with refused("split-shares-pose", "1.000", "2.000"):
        check_leakage(np.array([0, 1, 2]), poses, validation)


def dataset() -> Dataset:
    count = 6
    rng = np.random.default_rng(3)
    return Dataset(
        spec=DatasetSpec(),
        images_px=rng.uniform(0, 200, (count, 4, 2)),
        poses=np.column_stack([np.arange(count), np.zeros(count), [1.0, 4.0, 2.0, 4.0, 3.0, 4.0 + 1e-12]]),
        press=np.arange(count),
        validation=np.array([0, 0, 1, 0, 1, 0], bool),
        branch=np.array(["flat"] * count),
        travel_mm=np.arange(10.0, 10.0 + count),
        rest_px=rng.uniform(0, 200, (4, 2)),
        image_size_px=(346, 260),
        solved_presses=3,
        dropped={},
        forces=rng.normal(size=(count, 3)),
    )


def test_columns_of_a_dataset_have_a_row_for_each_image() -> None:
    whole = dataset()
    for name in ("poses", "press", "validation", "branch", "travel_mm"):
        with refused("dataset-column-lengths", 6, 5):
            replace(whole, **{name: getattr(whole, name)[:-1]})
    pixels = whole.images_px.copy()
    pixels[2, 1, 0] = np.nan
    with refused("dataset-not-finite"):
        replace(whole, images_px=pixels)


@pytest.mark.parametrize("held", [True, False])
def test_the_held_out_part_of_a_dataset_has_its_own_rows(held: bool) -> None:
    whole = dataset()
    part, rows = whole.subset(validation=held), whole.validation == held
    for name in ("images_px", "poses", "press", "branch", "travel_mm", "forces"):
        assert getattr(part, name).tolist() == getattr(whole, name)[rows].tolist()
    assert part.validation.tolist() == [held] * int(rows.sum())
    assert part.virtual_presses == rows.sum()
    assert replace(whole, forces=None).subset(validation=held).forces is None


def test_travel_at_full_depth_is_that_of_the_deepest_images() -> None:
    assert dataset().full_depth_travel_mm() == pytest.approx((11.0 + 13.0 + 15.0) / 3)


@pytest.mark.parametrize("protocol", ["paper-91", "paper-504"])
def test_protocols_of_tilts_are_refused_for_an_obstacle_that_does_not_tilt(protocol: str) -> None:
    with refused("protocol-not-for-obstacle", protocol):
        sample_poses(DatasetSpec(poses=protocol), 3.0)
    grid = sample_poses(DatasetSpec(poses=protocol))
    assert np.unique(np.hypot(*grid.T).round(6)).tolist() == [0, 2, 4, 6, 8, 10, 12]


@pytest.mark.parametrize(
    ("choice", "even"),
    [
        ({}, lambda r: r**2 / 9.0**2),
        ({"offset": 4.0}, lambda r: r**2 / 4.0**2),
        ({"offset": 4.0, "lies": True}, lambda r: r / 4.0),
        ({"offset": 50.0, "min_tilt_deg": 30.0}, lambda r: (r**2 - 900.0) / 1600.0),
    ],
)
def test_poses_fill_their_disc_line_or_ring_evenly(choice: dict, even) -> None:
    """The share of the area up to a pose is uniform from 0 to 1, and so is its direction."""
    poses = sample_poses(DatasetSpec(n_presses=2000, max_tilt_deg=9.0, seed=5), **choice)
    shares = (even(np.hypot(*poses.T)), np.arctan2(poses[:, 1], poses[:, 0]) / (2 * np.pi) % 1.0)
    for share in shares:
        assert np.sort(share) == pytest.approx((np.arange(2000) + 0.5) / 2000, abs=0.005)
    assert np.corrcoef(*shares)[0, 1] == pytest.approx(0.0, abs=0.02)
