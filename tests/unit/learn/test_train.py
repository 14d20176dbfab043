import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from synthetic import make_dataset

from errors import refused
from palpate.learn import TrainingSpec, evaluate, fit_ridge, paper_training, train

FAST = TrainingSpec(width=32, epochs=60, batch=64)


@pytest.fixture(scope="module")
def dataset():
    return make_dataset()


@pytest.fixture(scope="module")
def estimator(dataset):
    return train(dataset, FAST, seed=1)


def test_ridge_recovers_a_linear_map_without_jitter():
    dataset = make_dataset(bend=0.0, jitter_px=0.0)
    assert evaluate(fit_ridge(dataset), dataset).max_error_deg < 1e-5


def test_ridge_under_jitter_beats_the_fit_without_penalty():
    dataset = make_dataset(presses=15, bend=0.0)
    blind = fit_ridge(replace(dataset, spec=dataset.spec.model_copy(update={"jitter_px": 0.0})))
    errors = [
        np.mean([evaluate(e, dataset, seed).rmse_deg for seed in range(20)]) for e in (fit_ridge(dataset), blind)
    ]
    assert errors[0] < errors[1]


def test_perceptron_beats_ridge_on_a_bent_map():
    bent = make_dataset(presses=300, markers=3, bend=25.0)
    perceptron = evaluate(train(bent, FAST, seed=1), bent)
    assert perceptron.rmse_deg < 0.5 * evaluate(fit_ridge(bent), bent).rmse_deg


def test_jitter_makes_the_errors_larger(dataset, estimator):
    assert evaluate(estimator, dataset, 0).rmse_deg > 1.2 * evaluate(estimator, dataset).rmse_deg


def test_training_with_jitter_pays_under_jitter(dataset, estimator):
    blind = train(dataset, FAST.model_copy(update={"clean_share": 1.0}), seed=1)
    assert evaluate(estimator, dataset, 0).rmse_deg < 0.9 * evaluate(blind, dataset, 0).rmse_deg


def test_shuffled_labels_leave_the_spread_of_the_labels():
    dataset = make_dataset(presses=400)
    order = np.random.default_rng(0).permutation(400)
    poses = dataset.poses.reshape(400, 3, 3).copy()
    poses[..., :2] = poses[order][..., :2]
    shuffled = replace(dataset, poses=poses.reshape(-1, 3))
    found = evaluate(train(shuffled, TrainingSpec(width=8, epochs=10, repeats=1, learning_rate=3e-4)), shuffled)
    spread = shuffled.subset(validation=True).poses[:, :2].std()
    assert found.rmse_deg == pytest.approx(spread, rel=0.05)


def test_the_same_seed_gives_the_same_weights_and_another_seed_others(dataset, estimator):
    again, other = train(dataset, FAST, seed=1), train(dataset, FAST, seed=2)
    assert all(np.array_equal(a, b) for a, b in zip(estimator.weights, again.weights, strict=True))
    assert np.abs(estimator.weights[1] - other.weights[1]).max() > 0.1


def test_repeats_differ_from_each_other(estimator):
    first, second, third = estimator.weights[1]
    assert min(np.abs(first - second).max(), np.abs(second - third).max()) > 0.1


@pytest.mark.parametrize("dropout", [0.0, 0.5])
def test_a_repeat_trained_alone_equals_the_one_in_the_batch(dataset, dropout):
    short = FAST.model_copy(update={"epochs": 3, "dropout": dropout})
    together = train(dataset, short, seed=1)
    alone = train(dataset, short.model_copy(update={"repeats": 1}), seed=1)
    images = dataset.images_px[:20]
    assert np.allclose(alone.predict_members(images)[0], together.predict_members(images)[0], atol=1e-3)


def test_predicted_poses_do_not_need_torch(dataset, estimator, tmp_path):
    from palpate.learn import write_estimator

    write_estimator(tmp_path / "e.h5", estimator)
    np.save(tmp_path / "images.npy", dataset.images_px[:5])
    program = (
        "import sys; sys.modules['torch'] = None; import numpy as np; from pathlib import Path\n"
        "from palpate.learn import read_estimator\n"
        f"folder = Path({str(tmp_path)!r})\n"
        "poses = read_estimator(folder / 'e.h5').predict(np.load(folder / 'images.npy'))\n"
        "np.save(folder / 'poses.npy', poses)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
    again = np.load(tmp_path / "poses.npy")
    assert again == pytest.approx(estimator.predict(dataset.images_px[:5]), abs=1e-5)  # files are of single precision


def test_missing_torch_says_what_to_install(dataset, monkeypatch):
    monkeypatch.delitem(sys.modules, "palpate.learn.network", raising=False)
    monkeypatch.setitem(sys.modules, "torch", None)
    with refused("extra-missing", ".[learn]"):
        train(dataset, FAST)


def test_opening_the_front_door_does_not_load_torch():
    program = "import sys, palpate.learn; assert 'torch' not in sys.modules and 'optuna' not in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_markers_in_another_order_are_not_the_same_input(dataset, estimator):
    images = dataset.images_px[:50]
    assert np.abs(estimator.predict(images[:, ::-1]) - estimator.predict(images)).max() > 5.0


def test_another_layout_is_refused(dataset, estimator):
    with refused("model-marker-count"):
        estimator.predict(dataset.images_px[:, :5])


def test_training_on_all_presses_sees_no_held_out_image(dataset, estimator):
    moved = dataset.images_px.copy()
    moved[dataset.validation] += 50.0
    again = train(replace(dataset, images_px=moved), FAST, seed=1)
    assert all(np.array_equal(a, b) for a, b in zip(estimator.weights, again.weights, strict=True))
    assert estimator.training_images == 96 * 3


def test_plateau_keeps_the_best_epoch_and_stops_each_repeat_by_itself(dataset):
    spec = paper_training(2, 32, 0.0).model_copy(
        update={"stopping_patience": 3, "epochs": 200, "learning_rate": 1e-2, "members": "all"}
    )
    estimator = train(dataset, spec, seed=0)
    lengths = [len(errors) for errors in estimator.history]
    assert len(set(lengths)) > 1
    assert max(lengths) < 200
    for errors in estimator.history:
        assert int(np.argmin(errors)) == len(errors) - 1 - 3


def test_best_member_is_the_one_with_the_least_error(dataset):
    spec = paper_training(2, 16, 0.0).model_copy(update={"epochs": 5})
    everyone = train(dataset, spec.model_copy(update={"members": "all"}), seed=0)
    best = train(dataset, spec, seed=0)
    row = int(np.argmin([min(errors) for errors in everyone.history]))
    assert best.members == 1
    assert np.array_equal(best.weights[1][0], everyone.weights[1][row])


def test_printed_patience_never_drops_the_rate():
    spec = paper_training(3, 64, 0.5)
    assert (spec.plateau_patience, spec.stopping_patience, spec.learning_rate) == (100, 75, 1e-4)


def test_components_change_the_shape_of_the_inside_only(dataset):
    estimator = train(dataset, FAST.model_copy(update={"epochs": 2, "components": 6}), seed=0)
    assert estimator.weights[0].shape == (3, 24, 32)
    assert np.linalg.matrix_rank(estimator.weights[0][0]) == 6


def test_training_that_stops_being_a_number_is_reported(dataset):
    overflowing = replace(dataset, images_px=dataset.images_px * 1e36)
    with refused("training-diverged", "1"):
        train(overflowing, FAST)
