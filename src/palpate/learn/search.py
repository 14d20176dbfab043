"""Find an estimator for a design: train one network, or choose among many by Bayesian optimisation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from palpate.core import MissingExtraError, child_seed
from palpate.dataset import Dataset, hold_out
from palpate.learn.calibrate import calibrate
from palpate.learn.device import find_device
from palpate.learn.estimator import Estimator
from palpate.learn.space import BEST_SPACE, PAPER_SPACE, SearchSpace
from palpate.learn.spec import SearchSpec, TrainSpec
from palpate.learn.train import evaluate, train

if TYPE_CHECKING:
    import optuna

SPACES = {"paper": PAPER_SPACE, "best": BEST_SPACE}

FIRST_RUNG, REDUCTION = 10, 3
"""Epochs before a trial may be pruned, and the share (one in …) of trials that goes on from each rung."""


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
    chosen = TrainSpec()
    if (space := SPACES.get(spec.preset)) is not None:
        judged = _split_again(dataset, spec.seed) if space.inner_split else dataset
        chosen = space.final(_best_setting(judged, space, spec, journal))
    estimator = train(dataset, chosen, spec.seed, device=find_device(spec.device))
    return calibrate(estimator, dataset, spec.seed)


def _split_again(dataset: Dataset, seed: int) -> Dataset:
    """Only the presses for training, some of them held out anew."""
    kept = dataset.part(validation=False)
    fraction = dataset.spec.validation_fraction
    return replace(kept, validation=hold_out(kept.press, fraction, child_seed(seed, "inner split")))


def _best_setting(dataset: Dataset, space: SearchSpace, spec: SearchSpec, journal: Path) -> dict[str, Any]:
    study = _open_study(journal, space)
    trials = spec.trials or space.trials
    while (done := _finished(study)) < trials:
        # the sampler's stream hangs on the number of trials done, so that a resumed search repeats the same ones
        study.sampler = _sampler(child_seed(spec.seed, "trial", done) % 2**32)
        study.optimize(lambda trial: _judge(dataset, space, trial, spec), n_trials=1)
    return study.best_trial.params


def _judge(dataset: Dataset, space: SearchSpace, trial: optuna.Trial, spec: SearchSpec) -> float:
    """Score of one setting, as mean over its trainings."""
    setting = {name: trial.suggest_categorical(name, values) for name, values in space.choices.items()}

    def watch(epoch: int, error: float) -> None:
        import optuna

        trial.report(error, epoch)
        if trial.should_prune():
            raise optuna.TrialPruned

    watcher = watch if space.prunes else None
    estimator = train(dataset, space.trial(setting), spec.seed, watcher, find_device(spec.device))
    single = [estimator.keep_members([row]) for row in range(estimator.members)]
    scores = [
        space.score(evaluate(one, dataset).rmse_deg, evaluate(one, dataset, spec.seed).rmse_deg) for one in single
    ]
    return sum(scores) / len(scores)


def _open_study(journal: Path, space: SearchSpace) -> optuna.Study:
    try:
        import optuna
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend
    except ImportError as error:
        raise MissingExtraError("optuna", "learn") from error

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    pruner: optuna.pruners.BasePruner = optuna.pruners.NopPruner()
    if space.prunes:
        pruner = optuna.pruners.SuccessiveHalvingPruner(min_resource=FIRST_RUNG, reduction_factor=REDUCTION)
    return optuna.create_study(
        storage=JournalStorage(JournalFileBackend(str(journal))),
        study_name="search",
        direction="minimize",
        pruner=pruner,
        load_if_exists=True,
    )


def _sampler(seed: int) -> optuna.samplers.BaseSampler:
    import optuna

    return optuna.samplers.TPESampler(seed=seed)


def _finished(study: optuna.Study) -> int:
    """Number of trials that came to an end, pruned ones too."""
    import optuna

    states = (optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED)
    return len(study.get_trials(deepcopy=False, states=states))
