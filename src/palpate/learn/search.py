"""Find an estimator for a design: train one network, or search the paper's Table 1 by Bayesian optimisation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from palpate.core import MissingExtraError, child_seed
from palpate.dataset import Dataset
from palpate.learn.estimator import Estimator
from palpate.learn.spec import SearchSpec, TrainSpec, paper_training
from palpate.learn.train import evaluate, train

if TYPE_CHECKING:
    import optuna

LAYERS = (2, 3, 4, 5, 6, 7)
WIDTHS = (32, 64, 128, 256, 512, 1024)
DROPOUTS = (0.0, 0.5)
"""Table 1 of Zaid et al. 2024."""


def search(dataset: Dataset, spec: SearchSpec, journal: Path) -> Estimator:
    """Find an estimator.

    Parameters
    ----------
    dataset
        Clean images with their poses and split.
    spec
        Which preset, how many trials, seed.
    journal
        File of the search's finished trials; an interrupted search goes on from it and gives the same numbers
        as one that was never stopped. Not used by the preset ``"quick"``.

    Raises
    ------
    MissingExtraError
        If torch or optuna is not installed.
    """
    if spec.preset == "quick":
        return train(dataset, TrainSpec(), spec.seed)
    return train(dataset, _best_setting(dataset, spec, journal), spec.seed)


def _best_setting(dataset: Dataset, spec: SearchSpec, journal: Path) -> TrainSpec:
    """Setting with the least validation RMSE of both angles, under jitter, as mean of its trainings."""
    study = _open_study(journal)
    while (done := len(_finished(study))) < spec.trials:
        # the sampler's stream hangs on the number of trials done, so that a resumed search repeats the same ones
        study.sampler = _sampler(child_seed(spec.seed, "trial", done) % 2**32)
        study.optimize(lambda trial: _rmse(dataset, _suggest(trial), spec.seed), n_trials=1)
    return _setting(study.best_trial.params)


def _rmse(dataset: Dataset, setting: TrainSpec, seed: int) -> float:
    estimator = train(dataset, setting.model_copy(update={"members": "all"}), seed)
    single = [estimator.keep_members([row]) for row in range(estimator.members)]
    return sum(evaluate(member, dataset, seed).rmse_deg for member in single) / len(single)


def _suggest(trial: optuna.Trial) -> TrainSpec:
    return _setting(
        {
            "layers": trial.suggest_categorical("layers", LAYERS),
            "width": trial.suggest_categorical("width", WIDTHS),
            "dropout": trial.suggest_categorical("dropout", DROPOUTS),
        }
    )


def _setting(params: dict[str, float]) -> TrainSpec:
    return paper_training(int(params["layers"]), int(params["width"]), float(params["dropout"]))


def _open_study(journal: Path) -> optuna.Study:
    try:
        import optuna
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend
    except ImportError as error:
        raise MissingExtraError("optuna", "learn") from error

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    storage = JournalStorage(JournalFileBackend(str(journal)))
    return optuna.create_study(storage=storage, study_name="search", direction="minimize", load_if_exists=True)


def _sampler(seed: int) -> optuna.samplers.BaseSampler:
    import optuna

    return optuna.samplers.TPESampler(seed=seed)


def _finished(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    import optuna

    return study.get_trials(deepcopy=False, states=(optuna.trial.TrialState.COMPLETE,))
