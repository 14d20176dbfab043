import numpy as np
import pytest
from synthetic import make_dataset

from palpate.learn import SearchSpec, TrainSpec, search, train
from palpate.learn import search as search_function

pytest.importorskip("optuna")


def settings_tried(journal):
    import optuna
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    study = optuna.load_study(study_name="search", storage=JournalStorage(JournalFileBackend(str(journal))))
    complete = study.get_trials(states=(optuna.trial.TrialState.COMPLETE,))
    return [trial.params for trial in complete], [trial.value for trial in complete]


@pytest.fixture
def tabulated(monkeypatch):
    """Training replaced by a table: how the search walks does not hang on how long a training takes."""
    import sys

    module = sys.modules["palpate.learn.search"]

    def error(dataset, setting, seed):
        return abs(setting.layers - 4) + abs(np.log2(setting.width) - 8) + 4 * setting.dropout + 0.1

    monkeypatch.setattr(module, "_rmse", error)
    monkeypatch.setattr(module, "train", lambda dataset, setting, seed: setting)


def test_search_finds_the_best_setting_of_the_table(tabulated, tmp_path):
    best = search(None, SearchSpec(preset="paper", trials=40), tmp_path / "journal")
    assert (best.layers, best.width, best.dropout) == (4, 256, 0.0)


def test_an_interrupted_search_repeats_no_trial_and_ends_alike(tabulated, tmp_path, monkeypatch):
    import sys

    module = sys.modules["palpate.learn.search"]
    spec = SearchSpec(preset="paper", trials=12)
    search(None, spec, tmp_path / "whole")
    error = module._rmse
    calls = []

    def interrupted(dataset, setting, seed):
        calls.append(setting)
        if len(calls) == 7:
            raise KeyboardInterrupt
        return error(dataset, setting, seed)

    monkeypatch.setattr(module, "_rmse", interrupted)
    with pytest.raises(KeyboardInterrupt):
        search(None, spec, tmp_path / "broken")
    search(None, spec, tmp_path / "broken")
    assert len(calls) == 12 + 1
    assert settings_tried(tmp_path / "broken") == settings_tried(tmp_path / "whole")


def test_trials_stay_in_table_1_and_use_the_printed_protocol(tabulated, tmp_path):
    best = search_function(None, SearchSpec(preset="paper", trials=15, seed=3), tmp_path / "journal")
    tried, _ = settings_tried(tmp_path / "journal")
    assert {p["layers"] for p in tried} <= {2, 3, 4, 5, 6, 7}
    assert {p["width"] for p in tried} <= {32, 64, 128, 256, 512, 1024}
    assert {p["dropout"] for p in tried} <= {0.0, 0.5}
    assert (best.learning_rate, best.repeats, best.clean_share, best.components) == (1e-4, 3, 0.0, 0)


def test_quick_trains_one_network_and_leaves_no_journal(tmp_path):
    dataset = make_dataset(presses=20, markers=3)
    found = search(dataset, SearchSpec(seed=5), tmp_path / "journal")
    assert not (tmp_path / "journal").exists()
    assert np.array_equal(found.weights[0], train(dataset, TrainSpec(), 5).weights[0])


def test_paper_search_on_real_training_gives_an_estimator(tmp_path, monkeypatch):
    import sys

    module = sys.modules["palpate.learn.search"]
    monkeypatch.setattr(module, "LAYERS", (2,))
    monkeypatch.setattr(module, "WIDTHS", (32,))
    printed = module.paper_training
    monkeypatch.setattr(module, "paper_training", lambda *setting: printed(*setting).model_copy(update={"epochs": 3}))
    estimator = search(make_dataset(presses=20), SearchSpec(preset="paper", trials=2), tmp_path / "journal")
    assert estimator.members == 1
    _, errors = settings_tried(tmp_path / "journal")
    assert len(errors) == 2
    assert all(0 < error < 20 for error in errors)
