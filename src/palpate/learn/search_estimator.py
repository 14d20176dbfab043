"""Find an estimator for a design: default settings, or those chosen by Bayesian optimisation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from palpate.core import MissingExtraError, child_seed
from palpate.datasets import Dataset, split_presses
from palpate.learn.calibrate import calibrate_interval
from palpate.learn.device import find_device
from palpate.learn.estimator import Estimator
from palpate.learn.space import BEST_SPACE, PAPER_SPACE, HyperparameterSpace
from palpate.learn.spec import LearningSpec, TrainingSpec
from palpate.learn.train import evaluate, train

if TYPE_CHECKING:
    import optuna

SPACES = {"paper": PAPER_SPACE, "best": BEST_SPACE}

REDUCTION = 3
"""One in this number of trials is promoted to the next rung."""
STARTUP = 5
"""Random settings before proposals by the model. By hand."""


def search_estimator(dataset: Dataset, spec: LearningSpec, journal: Path) -> Estimator:
    """Find an estimator.

    Parameters
    ----------
    dataset
        Clean images with their poses and split.
    spec
        Preset, number of trials, seed.
    journal
        File of the search's finished trials; an interrupted search resumes from it and gives the same numbers
        as an uninterrupted one. Not used by the preset ``"quick"``.

    Raises
    ------
    MissingExtraError
        If torch or optuna is not installed.
    """
    chosen = TrainingSpec()
    if (space := SPACES.get(spec.preset)) is not None:
        judged = _split_again(dataset, spec.seed) if space.inner_split else dataset
        chosen = space.final(_best_setting(judged, space, spec, journal))
    estimator = train(dataset, chosen, spec.seed, device=find_device(spec.device))
    return calibrate_interval(estimator, dataset, spec.seed)


def _split_again(dataset: Dataset, seed: int) -> Dataset:
    """Return the training presses, with a new split."""
    kept = dataset.subset(validation=False)
    fraction = dataset.spec.validation_fraction
    inner = split_presses(kept.press, child_seed(seed, "inner split"), fraction)
    return replace(kept, validation=inner.validation)


def _best_setting(dataset: Dataset, space: HyperparameterSpace, spec: LearningSpec, journal: Path) -> dict[str, Any]:
    study = _open_study(journal)
    trials = spec.trials or space.trials
    while (done := len(_ended(study))) < trials:
        # the sampler's stream depends on the number of trials done, so that a resumed search repeats the same ones
        study.sampler = _sampler(child_seed(spec.seed, "trial", done) % 2**32)
        study.optimize(lambda trial: _validate(dataset, space, trial, spec), n_trials=1)
    return study.best_trial.params


def _validate(dataset: Dataset, space: HyperparameterSpace, trial: optuna.Trial, spec: LearningSpec) -> float:
    """Score one setting by trainings of increasing length, ended early if its score is poor."""
    import optuna

    training = space.trial({name: trial.suggest_categorical(name, values) for name, values in space.choices.items()})
    rungs = space.rungs or (training.epochs,)
    known = _tried_before(trial)
    for epochs in rungs:
        if epochs not in known:
            known[epochs] = _score(dataset, space, training.model_copy(update={"epochs": epochs}), spec)
        trial.report(score := known[epochs], epochs)
        if epochs < rungs[-1] and _is_hopeless(score, epochs, trial):
            raise optuna.TrialPruned
    return score


def _tried_before(trial: optuna.Trial) -> dict[int, float]:
    """Scores by epochs of a finished trial of the same setting, which is not trained again."""
    same = [other.intermediate_values for other in _ended(trial.study) if other.params == trial.params]
    return {epochs: score for scores in same for epochs, score in scores.items()}


def _is_hopeless(score: float, epochs: int, trial: optuna.Trial) -> bool:
    """Whether a score is not in the best part of all trials after as many epochs (ASHA, Li et al. 2020).

    Optuna's own pruner counts interrupted trials as well, so that a resumed search could differ.
    """
    found = [other.intermediate_values for other in _ended(trial.study)]
    scores = sorted([score, *(scores[epochs] for scores in found if epochs in scores)])
    return score > scores[max(len(scores) // REDUCTION, 1) - 1]


def _score(dataset: Dataset, space: HyperparameterSpace, training: TrainingSpec, spec: LearningSpec) -> float:
    """Objective of a setting: mean score over its trainings."""
    estimator = train(dataset, training, spec.seed, device=find_device(spec.device))
    single = [estimator.keep_members([row]) for row in range(estimator.members)]
    scores = [
        space.score(evaluate(one, dataset).rmse_deg, evaluate(one, dataset, spec.seed).rmse_deg) for one in single
    ]
    return sum(scores) / len(scores)


def _open_study(journal: Path) -> optuna.Study:
    try:
        import optuna
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend
    except ImportError as error:
        raise MissingExtraError("optuna", "learn") from error

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna.create_study(
        storage=JournalStorage(JournalFileBackend(str(journal))),
        study_name="search",
        direction="minimize",
        load_if_exists=True,
    )


def _sampler(seed: int) -> optuna.samplers.BaseSampler:
    import optuna

    return optuna.samplers.TPESampler(seed=seed, n_startup_trials=STARTUP)


def _ended(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    """Completed and pruned trials in their order, without interrupted ones."""
    import optuna

    states = (optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED)
    return study.get_trials(deepcopy=False, states=states)
