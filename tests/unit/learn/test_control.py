from dataclasses import replace

import numpy as np
import pytest
from synthetic import make_dataset

from errors import refused
from palpate.learn import TrainingSpec, compare_splits, evaluate, shuffle_labels, train

EARLY = TrainingSpec(schedule="plateau", plateau_patience=5, stopping_patience=15, epochs=80, repeats=2)


def curious_dataset():
    """Every press has a mark of its own in the image, so that one who has seen it at another depth knows its pose."""
    dataset = make_dataset(presses=100, markers=40, jitter_px=0.1, depths=(2.4, 3.2, 4.0, 4.8, 5.6))
    rng = np.random.default_rng(0)
    mark = rng.normal(0, 10.0, (100, 40, 2))
    return replace(dataset, images_px=dataset.rest_px + mark[dataset.press])


def test_a_split_by_image_flatters_where_presses_can_be_recognised():
    spec = TrainingSpec(epochs=40, batch=32, repeats=1, components=0, clean_share=1.0)
    found = compare_splits(curious_dataset(), spec, seed=1)
    assert found.optimism_factor > 2.0
    assert found.by_press.images == found.by_image.images == 100


def test_a_split_by_image_flatters_little_where_the_pose_is_all_there_is():
    found = compare_splits(make_dataset(presses=300), TrainingSpec(width=32, epochs=40), seed=1)
    assert 0.7 < found.optimism_factor < 1.4


def test_the_honest_side_of_the_comparison_is_the_training_of_the_grid():
    dataset, spec = make_dataset(), TrainingSpec(width=16, epochs=5)
    found = compare_splits(dataset, spec, seed=3)
    assert found.by_press == evaluate(train(dataset, spec, seed=3), dataset)


def test_a_dataset_split_by_image_cannot_be_made():
    dataset = make_dataset()
    with refused("split-shares-press"):
        replace(dataset, validation=np.random.default_rng(0).random(len(dataset.poses)) < 0.2)


def test_shuffled_labels_are_those_of_other_presses_and_keep_depth_and_split():
    dataset = make_dataset()
    shuffled = shuffle_labels(dataset, seed=1)
    assert np.array_equal(shuffled.poses[:, 2], dataset.poses[:, 2])
    assert (shuffled.poses[:, :2] != dataset.poses[:, :2]).any(axis=1).mean() > 0.9
    for side in (False, True):
        old, new = (np.unique(d.poses[d.validation == side][:, :2], axis=0) for d in (dataset, shuffled))
        assert np.array_equal(old, new)


def test_learning_from_shuffled_labels_leaves_their_spread():
    shuffled = shuffle_labels(make_dataset(presses=1000), seed=2)
    spread = np.sqrt((shuffled.subset(validation=True).poses[:, :2] ** 2).mean())
    assert evaluate(train(shuffled, EARLY), shuffled).rmse_deg == pytest.approx(spread, rel=0.05)
