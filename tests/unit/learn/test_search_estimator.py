import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from synthetic import make_dataset

from needs import needs
from palpate.learn import LearningSpec, TrainingSpec, search_estimator, train
from palpate.learn import search_estimator as search_function

needs("optuna")


def trials_of(journal):
    import optuna
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    study = optuna.load_study(study_name="search", storage=JournalStorage(JournalFileBackend(str(journal))))
    return study.get_trials()


def settings_tried(journal):
    complete = [trial for trial in trials_of(journal) if trial.state.name == "COMPLETE"]
    return [trial.params for trial in complete], [trial.value for trial in complete]


@pytest.fixture
def tabulated(monkeypatch):
    """Training replaced by a table: how the search walks does not depend on how long a training takes."""
    module = sys.modules["palpate.learn.search_estimator"]

    def error(dataset, space, trial, spec):
        setting = {name: trial.suggest_categorical(name, values) for name, values in space.choices.items()}
        return abs(setting["layers"] - 4) + abs(np.log2(setting["width"]) - 8) + 4 * setting["dropout"] + 0.1

    monkeypatch.setattr(module, "_validate", error)
    monkeypatch.setattr(module, "train", lambda dataset, setting, seed, device: setting)
    monkeypatch.setattr(module, "calibrate_interval", lambda setting, dataset, seed: setting)


def test_search_finds_the_best_setting_of_the_table(tabulated, tmp_path):
    best = search_estimator(None, LearningSpec(preset="paper", trials=40), tmp_path / "journal")
    assert (best.layers, best.width, best.dropout) == (4, 256, 0.0)


def test_an_interrupted_search_repeats_no_trial_and_ends_alike(tabulated, tmp_path, monkeypatch):
    module = sys.modules["palpate.learn.search_estimator"]
    spec = LearningSpec(preset="paper", trials=12)
    search_estimator(None, spec, tmp_path / "whole")
    error = module._validate
    calls = []

    def interrupted(dataset, space, trial, spec):
        calls.append(trial)
        if len(calls) == 7:
            raise KeyboardInterrupt
        return error(dataset, space, trial, spec)

    monkeypatch.setattr(module, "_validate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        search_estimator(None, spec, tmp_path / "broken")
    search_estimator(None, spec, tmp_path / "broken")
    assert len(calls) == 12 + 1
    assert settings_tried(tmp_path / "broken") == settings_tried(tmp_path / "whole")


def test_trials_stay_in_table_1_and_use_the_printed_protocol(tabulated, tmp_path):
    best = search_function(None, LearningSpec(preset="paper", trials=15, seed=3), tmp_path / "journal")
    tried, _ = settings_tried(tmp_path / "journal")
    assert {p["layers"] for p in tried} <= {2, 3, 4, 5, 6, 7}
    assert {p["width"] for p in tried} <= {32, 64, 128, 256, 512, 1024}
    assert {p["dropout"] for p in tried} <= {0.0, 0.5}
    assert (best.learning_rate, best.repeats, best.clean_share, best.components) == (1e-4, 3, 0.0, 0)


def test_quick_trains_one_network_and_leaves_no_journal(tmp_path):
    dataset = make_dataset(presses=20, markers=3)
    found = search_estimator(dataset, LearningSpec(seed=5), tmp_path / "journal")
    assert not (tmp_path / "journal").exists()
    assert np.array_equal(found.weights[0], train(dataset, TrainingSpec(), 5).weights[0])


def shrink(monkeypatch, preset, epochs, **choices):
    """The preset's own search with less to choose and shorter trainings."""
    module = sys.modules["palpate.learn.search_estimator"]
    space = module.SPACES[preset]
    small = replace(
        space,
        choices={name: choices.get(name, values[:1]) for name, values in space.choices.items()},
        rungs=tuple(epochs * (number + 1) for number, _ in enumerate(space.rungs)),
        trial=lambda setting: space.trial(setting).model_copy(update={"epochs": epochs}),
        final=lambda setting: space.final(setting).model_copy(update={"epochs": epochs}),
    )
    monkeypatch.setitem(module.SPACES, preset, small)


def test_paper_search_on_real_training_gives_one_network(tmp_path, monkeypatch):
    shrink(monkeypatch, "paper", 3)
    estimator = search_estimator(
        make_dataset(presses=20), LearningSpec(preset="paper", trials=2), tmp_path / "journal"
    )
    assert estimator.members == 1
    _, errors = settings_tried(tmp_path / "journal")
    assert len(errors) == 2
    assert all(0 < error < 20 for error in errors)


def test_best_search_prunes_and_the_paper_does_not(tmp_path, monkeypatch):
    import optuna

    states = {}
    for preset, name, values in (("best", "clean_share", (0.25, 1.0)), ("paper", "width", (32, 64))):
        shrink(monkeypatch, preset, 20, **{name: values})
        search_estimator(
            make_dataset(presses=20, markers=4), LearningSpec(preset=preset, trials=6), tmp_path / preset
        )
        states[preset] = {trial.state for trial in trials_of(tmp_path / preset)}
    assert optuna.trial.TrialState.PRUNED in states["best"]
    assert states["paper"] == {optuna.trial.TrialState.COMPLETE}


@pytest.fixture
def scored(monkeypatch):
    """Best search whose scores are a table: wider and cleaner is better, and more epochs help."""
    module, asked = sys.modules["palpate.learn.search_estimator"], []

    def score(dataset, space, training, spec):
        asked.append((training.layers, training.width, training.components, training.clean_share, training.epochs))
        return 128 / training.width + abs(training.clean_share - 0.75) + 10 / training.epochs

    monkeypatch.setattr(module, "_score", score)
    monkeypatch.setattr(module, "_split_again", lambda dataset, seed: dataset)
    monkeypatch.setattr(module, "train", lambda dataset, setting, seed, device: setting)
    monkeypatch.setattr(module, "calibrate_interval", lambda setting, dataset, seed: setting)
    return asked


def test_a_later_trial_beats_the_first_where_it_is_better(scored, tmp_path):
    found = search_estimator(None, LearningSpec(preset="best", trials=25), tmp_path / "journal")
    assert (found.width, found.clean_share) == (256, 0.75)
    first = trials_of(tmp_path / "journal")[0].params
    assert (first["width"], first["clean_share"]) != (256, 0.75)


def test_no_setting_is_trained_twice_and_hopeless_ones_are_not_trained_long(scored, tmp_path):
    search_estimator(None, LearningSpec(preset="best", trials=25), tmp_path / "journal")
    assert len(set(scored)) == len(scored)
    short, long = (sum(epochs == rung for *_, epochs in scored) for rung in (15, 45))
    assert 0 < long < short < 25


def test_a_best_search_that_was_interrupted_anywhere_ends_alike(scored, tmp_path, monkeypatch):
    module = sys.modules["palpate.learn.search_estimator"]
    spec, score = LearningSpec(preset="best", trials=8), sys.modules["palpate.learn.search_estimator"]._score
    search_estimator(None, spec, tmp_path / "whole")
    calls = []

    def interrupted(*words):
        calls.append(words)
        if len(calls) % 3 == 0:
            raise KeyboardInterrupt
        return score(*words)

    monkeypatch.setattr(module, "_score", interrupted)
    for _ in range(20):
        try:
            search_estimator(None, spec, tmp_path / "broken")
            break
        except KeyboardInterrupt:
            continue
    ended = [
        [(t.params, t.state, t.intermediate_values) for t in trials_of(tmp_path / name) if t.state.is_finished()]
        for name in ("broken", "whole")
    ]
    assert [e for e in ended[0] if e[1].name != "FAIL"] == ended[1]


def test_best_search_chooses_without_the_held_out_presses(tmp_path, monkeypatch):
    shrink(monkeypatch, "best", 12, width=(128, 256), clean_share=(0.25, 0.5))
    dataset = make_dataset(presses=30, markers=4)
    moved = dataset.images_px.copy()
    moved[dataset.validation] += 50.0
    spec = LearningSpec(preset="best", trials=4)
    search_estimator(dataset, spec, tmp_path / "one")
    search_estimator(replace(dataset, images_px=moved), spec, tmp_path / "two")
    assert settings_tried(tmp_path / "one") == settings_tried(tmp_path / "two")


def test_what_a_search_finds_is_calibrated_on_presses_that_trained_nothing(tmp_path):
    dataset = make_dataset(presses=150, markers=3)
    found = search_estimator(dataset, LearningSpec(seed=5), tmp_path / "journal")
    held = set(dataset.press[dataset.validation])
    assert set(found.interval.presses) < held
    assert len(found.interval.presses) == len(held) // 2


@pytest.mark.slow
def test_the_same_seed_gives_the_same_numbers_in_a_fresh_process(tmp_path):
    program = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "import hashlib; from pathlib import Path; from synthetic import make_dataset\n"
        "from palpate.learn import LearningSpec, search_estimator, write_estimator\n"
        "model, seed = Path(sys.argv[1]), int(sys.argv[2])\n"
        "dataset = make_dataset(presses=60, markers=3)\n"
        "write_estimator(model, search_estimator(dataset, LearningSpec(seed=seed), model.with_suffix('.journal')))\n"
        "print(hashlib.sha256(model.read_bytes()).hexdigest())\n"
    )

    def digest(name, seed):
        words = [sys.executable, "-c", program, str(tmp_path / name), seed]
        return subprocess.run(words, check=True, capture_output=True, text=True).stdout

    assert digest("one.onnx", "4") == digest("two.onnx", "4") != digest("three.onnx", "5")
