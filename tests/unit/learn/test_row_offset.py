"""Row offsets between poses and images: found on rows that did not train."""

import numpy as np
import pytest

from palpate.learn.row_offset import find_row_offset


@pytest.mark.parametrize("lost", [-3, -1, 0, 2, 3])
@pytest.mark.parametrize("seed", [0, 1])
def test_an_offset_is_found_by_rows_that_did_not_train(lost: int, seed: int) -> None:
    """As many components as rows train: there, poses fit images at every offset; elsewhere at one."""
    rng = np.random.default_rng(seed)
    poses = rng.normal(size=(60, 2))
    features = np.column_stack([100.0 * poses, rng.normal(size=(60, 40))])
    train = np.zeros(60, bool)
    train[rng.permutation(60)[:20]] = True
    assert find_row_offset(features, np.roll(poses, -lost, axis=0), train) == lost


def test_a_slow_motion_and_poses_of_another_run_have_no_offset() -> None:
    """No offset fits better than another by two fifths."""
    rng = np.random.default_rng(3)
    time, train = np.linspace(0.0, 1.0, 200), np.arange(200) % 2 == 0
    slow = np.column_stack([time, time**2])
    assert find_row_offset(slow[2:] + 0.05 * rng.normal(size=(198, 2)), slow[:-2], train[2:]) == 0
    assert find_row_offset(rng.normal(size=(200, 5)), rng.normal(size=(200, 2)), train) == 0


def test_without_an_image_to_test_the_fits_there_is_no_offset():
    rng = np.random.default_rng(0)
    assert find_row_offset(rng.normal(size=(8, 4)), rng.normal(size=(8, 3)), np.ones(8, bool)) == 0
