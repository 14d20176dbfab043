"""Gaussian processes: symmetry, few presses, wrong images."""

from functools import cache

import numpy as np
import pytest

from drawn_tactip import DrawnSensor, draw_motions, place_heads
from palpate.learn.gaussian_process import (
    choose_symmetry,
    covariance,
    predict_process,
    squared_distances,
    train_process,
)
from palpate.learn.member import MarkerProcess, MarkerRidge, TrainingRun
from palpate.learn.rotation import RotationAugmentation, RotationOperators, find_rotation, rotation
from palpate.learn.training_set import TrainingSet

SENSOR, COUNT, TEST = DrawnSensor(rings=5, pattern="rings"), 260, 60
AXES = ("rx", "ry", "depth")


@cache
def drawn() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Dots at rest (m, 2), displacements (n, m, 2) with noise, and poses (n, 3)."""
    rest = place_heads(SENSOR, np.zeros(6), np.zeros((4, 2)))[0]
    motions, rng = draw_motions(COUNT, 2, tilt=25.0), np.random.default_rng(4)
    heads = np.array([place_heads(SENSOR, one, rng.normal(0, 0.02, (4, 2)))[0] for one in motions])
    return rest, heads - rest + rng.normal(0, 0.1, heads.shape), motions[:, :3]


def samples(count: int, symmetric: bool = True, wrong: float = 0.0) -> TrainingSet:
    rest, moved, poses = drawn()
    moved, rng = moved.copy(), np.random.default_rng(5)
    bad = np.flatnonzero(rng.random(count) < wrong)
    moved[bad] = moved[bad][:, rng.permutation(len(rest))]
    train = np.arange(COUNT) < count
    found = find_rotation(rest, moved[train], poses[train], AXES, True) if symmetric else None
    return TrainingSet(moved, poses, train, train, 0, found)


def errors(arrays: dict[str, np.ndarray]) -> np.ndarray:
    _, moved, poses = drawn()
    found = predict_process(arrays, moved[-TEST:])
    return np.sqrt(np.mean((found - poses[-TEST:]) ** 2, axis=0))


@pytest.mark.parametrize(("presses", "tilt_deg", "depth_mm"), [(10, 4.0, 1.3), (30, 2.2, 0.4), (100, 1.2, 0.2)])
def test_few_presses_teach_what_ridge_does_not(presses: int, tilt_deg: float, depth_mm: float) -> None:
    lesson = samples(presses)
    found = errors(train_process(lesson))
    assert max(found[:2]) < tilt_deg
    assert found[2] < depth_mm
    plain = errors(train_process(samples(presses, symmetric=False)))
    ridge = MarkerRidge.train("ridge", lesson, TrainingRun()).predict(drawn()[1][-TEST:]) - drawn()[2][-TEST:]
    assert found[:2].mean() < 0.6 * plain[:2].mean()
    assert found[:2].mean() < 0.6 * np.sqrt(np.mean(ridge[:, :2] ** 2))


def test_a_turned_or_reflected_press_gives_the_turned_pose() -> None:
    lesson = choose_symmetry(samples(60))
    assert lesson is not None
    assert lesson.angles == "ry-rx"  # the drawn normal is that of Ry Rx
    _, moved, _ = drawn()
    arrays = train_process(TrainingSet(*_fields(samples(60)), rotation=lesson))
    turns = RotationOperators(lesson.places_px)
    for turn in (rotation(6), rotation(9) @ np.diag([1.0, -1.0])):
        fields = moved[-TEST:].reshape(TEST, -1) @ turns.operator(turn).T
        turned = predict_process(arrays, fields.reshape(TEST, -1, 2))
        assert turned == pytest.approx(lesson.turn_targets(predict_process(arrays, moved[-TEST:]), turn), abs=0.5)


def _fields(found: TrainingSet) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    return found.inputs, found.targets, found.train, found.validation


def test_the_covariance_is_symmetric_and_positive() -> None:
    arrays = train_process(samples(40))
    for number in range(2):
        moved = arrays["features"] @ arrays["elements"].transpose(0, 2, 1)
        distances = squared_distances(arrays["features"], moved, arrays[f"scale_{number}"])
        matrix = covariance(distances, arrays[f"actions_{number}"])
        assert np.abs(matrix - matrix.T).max() < 1e-9
        assert np.linalg.eigvalsh(matrix)[0] > -1e-9


def test_wrong_images_are_left_out() -> None:
    right, wrong = train_process(samples(150)), train_process(samples(150, wrong=0.03))
    assert len(wrong["features"]) < 150
    assert errors(wrong)[:2].mean() < 1.35 * errors(right)[:2].mean()


def test_far_from_all_presses_the_estimate_is_the_mean() -> None:
    arrays = train_process(samples(30))
    far = predict_process(arrays, 100.0 * drawn()[1][-TEST:])
    assert far == pytest.approx(np.tile(arrays["mean"], (TEST, 1)), abs=1e-6)


def test_single_precision_in_a_file_changes_nothing_that_matters() -> None:
    arrays = train_process(samples(100))
    short = {name: np.float32(values) if values.ndim > 1 else values for name, values in arrays.items()}
    moved = drawn()[1][-TEST:]
    assert predict_process(short, moved) == pytest.approx(predict_process(arrays, moved), abs=0.01)


def test_images_of_one_press_are_left_out_together() -> None:
    """With copies of each press the error is that of other presses, not of copies."""
    lesson = samples(30)
    rows = np.tile(np.arange(30), 3)
    copied = TrainingSet(
        lesson.inputs[rows],
        lesson.targets[rows],
        np.ones(90, bool),
        np.ones(90, bool),
        0,
        lesson.rotation,
        press=rows,
    )
    alone = TrainingSet(*_fields(copied), rotation=lesson.rotation)
    apart = float(train_process(lesson)["error"])
    assert float(train_process(copied)["error"]) == pytest.approx(apart, rel=0.4)
    assert float(train_process(alone)["error"]) < 0.5 * apart


def test_a_symmetry_that_is_wrong_is_seen_in_the_left_out_error() -> None:
    lesson = samples(60)
    assert lesson.rotation is not None
    other = lesson.rotation._replace(sense=-lesson.rotation.sense)
    wrong = TrainingSet(*_fields(lesson), rotation=RotationAugmentation(*other))
    assert float(train_process(wrong)["error"]) > 3 * float(train_process(lesson)["error"])


def test_an_odd_target_with_a_mean_is_learnt_with_reflections() -> None:
    rest, moved, _ = drawn()
    motions = draw_motions(COUNT, 2, tilt=25.0)
    poses = np.c_[motions[:, :3], motions[:, 5] + 10.0]  # rz with a mean of 10 degrees
    turned = moved + np.radians(10.0) * 0.3 * np.stack(
        [-(rest - rest.mean(0))[:, 1], (rest - rest.mean(0))[:, 0]], -1
    )
    train = np.arange(COUNT) < 120
    found = find_rotation(rest, turned[train], poses[train], ("rx", "ry", "depth", "rz"), True)
    assert found is not None
    assert found.odd == (3,)
    arrays = train_process(TrainingSet(turned, poses, train, train, 0, found))
    error = predict_process(arrays, turned[-TEST:])[:, 3] - poses[-TEST:, 3]
    assert np.sqrt(np.mean(error**2)) < 0.6 * poses[:, 3].std()


def test_a_fine_tuned_process_is_tuned_again_and_its_outputs_are_mapped() -> None:
    _, moved, poses = drawn()
    process = MarkerProcess("first", train_process(samples(40)))
    lesson = samples(80)
    shifted = TrainingSet(lesson.inputs, lesson.targets + np.array([1.0, -2.0, 0.5]), lesson.train, lesson.validation)
    once = process.fine_tune("once", shifted)
    twice = once.fine_tune("twice", lesson)
    assert np.sqrt(np.mean((twice.predict(moved[-TEST:]) - poses[-TEST:])[:, :2] ** 2)) < 3.0
    turn, shift = np.array([[0.0, 2.0], [1.0, 0.0], [0.0, 0.0]]), np.array([0.3, -0.1])
    mapped = twice.transform_outputs("mapped", turn, shift)
    assert mapped.predict(moved[-TEST:]) == pytest.approx(twice.predict(moved[-TEST:]) @ turn + shift)
    size = moved.shape[1] * 2
    doubled = twice.transform_inputs(0.5 * np.eye(size)).predict(2.0 * moved[-TEST:])
    assert doubled == pytest.approx(twice.predict(moved[-TEST:]))


def test_constant_targets_and_few_images_do_not_stop_it() -> None:
    lesson = samples(30)
    flat = TrainingSet(
        lesson.inputs, lesson.targets * [1.0, 1.0, 0.0], lesson.train, lesson.train, 0, lesson.rotation
    )
    assert predict_process(train_process(flat), drawn()[1][-3:])[:, 2] == pytest.approx(0.0)
    still = TrainingSet(0.0 * lesson.inputs, lesson.targets, lesson.train, lesson.train)
    assert np.isfinite(predict_process(train_process(still), drawn()[1][-3:])).all()
