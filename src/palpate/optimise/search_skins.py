"""Bayesian optimisation over skins, by a Gaussian process on the trials so far.

Places are proposed in batches of fixed size and seed, whatever the number of workers. All trials are in a journal: a
resumed search completes the trials it had begun, then makes the proposals of an uninterrupted one.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from palpate.core import MissingExtraError, child_seed
from palpate.optimise.space import Place, SkinSpace

if TYPE_CHECKING:
    import optuna

BATCH = 4
"""Places per batch. By hand."""
_STARTUP = 8
"""Places drawn at random before the process is fitted. By hand."""
Sampler = Literal["gp", "random"]


@dataclass(frozen=True)
class Evaluation:
    """Evaluation of one place.

    Attributes
    ----------
    values
        Values to minimise; infinite if unknown (the process then uses the worst known value).
    violations
        Constraints by name; above 0 if violated.
    record
        Data that are stored with the trial.
    """

    values: tuple[float, ...]
    violations: Mapping[str, float]
    record: Mapping[str, Any]


@dataclass(frozen=True)
class SearchTrial:
    """Evaluated place; `number` is its order of proposal."""

    number: int
    place: Place
    evaluation: Evaluation


@dataclass(frozen=True)
class SearchPlan:
    """Settings of a search.

    Attributes
    ----------
    trials
        Number of places, including those of earlier runs with the same journal.
    seed, sampler
        Seed and kind of the proposals; ``"random"`` is the baseline.
    initial
        Initial places.
    n_objectives
        Number of objective values.
    max_hours
        Time after which no further batch is begun.
    """

    trials: int
    seed: int = 0
    sampler: Sampler = "gp"
    initial: tuple[Place, ...] = ()
    n_objectives: int = 1
    max_hours: float = 1e9


def search_skins(
    space: SkinSpace,
    evaluate: Callable[[Sequence[Place]], Sequence[Evaluation]],
    plan: SearchPlan,
    journal: Path,
    on_batch: Callable[[Sequence[SearchTrial]], None] | None = None,
) -> tuple[SearchTrial, ...]:
    """Evaluate places of a search space and return all trials in the order of their proposal.

    Parameters
    ----------
    space
        Ranges of the variables.
    evaluate
        Returns objective values and constraint violations of several places.
    plan
        Number of trials, sampler, seed and initial places.
    journal
        File of the search; trials it contains are not evaluated again.
    on_batch
        Called with all trials after every batch.

    Raises
    ------
    MissingExtraError
        If optuna or torch is not installed.
    """
    study, begun = _open(journal, plan.n_objectives), time.monotonic()
    if not study.trials:
        for place in plan.initial:
            study.enqueue_trial(dict(place))
    for start in range(0, plan.trials, BATCH):
        numbers = range(start, min(start + BATCH, plan.trials))
        there = study.get_trials(deepcopy=False)[start : numbers.stop]
        if len([trial for trial in there if trial.state.name == "COMPLETE"]) == len(numbers):
            continue
        if time.monotonic() - begun > 3600.0 * plan.max_hours:
            break
        asked = [trial for number in numbers if (trial := _ask(study, space, number, plan)) is not None]
        for trial, found in zip(asked, evaluate([trial.params for trial in asked]), strict=True):
            _report(study, trial, found)
        if on_batch is not None:
            on_batch(_tried(study))
    return _tried(study)


def read_trials(journal: Path, objectives: int = 1) -> tuple[SearchTrial, ...]:
    """Read the completed trials of a journal; empty if the file does not exist."""
    return _tried(_open(journal, objectives)) if journal.exists() else ()


def rewrite_journal(journal: Path, space: SkinSpace, plan: SearchPlan, tried: Sequence[SearchTrial]) -> None:
    """Replace a journal by one with the same places and new evaluations, the basis of later proposals."""
    new = journal.with_name(f"{journal.name}.new")
    new.unlink(missing_ok=True)
    study, told = _open(new, plan.n_objectives), replace(plan, sampler="random")  # which need not fit what is given
    for one in tried:
        study.enqueue_trial(dict(one.place))
        trial = _ask(study, space, one.number, told)
        assert trial is not None
        _report(study, trial, one.evaluation)
    new.replace(journal)


def _tried(study: optuna.Study) -> tuple[SearchTrial, ...]:
    """Evaluated places in the order of their proposal."""
    done = [trial for trial in study.get_trials(deepcopy=False) if trial.state.name == "COMPLETE"]
    return tuple(SearchTrial(trial.number, trial.params, _evaluation(trial)) for trial in done)


def _open(journal: Path, objectives: int) -> optuna.Study:
    try:
        import optuna
        import torch  # noqa: F401  (the Gaussian process is on it)
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend
    except ImportError as error:
        raise MissingExtraError(error.name or "optuna", "learn") from error
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna.create_study(
        storage=JournalStorage(JournalFileBackend(str(journal))),
        study_name="skins",
        directions=["minimize"] * objectives,
        load_if_exists=True,
    )


def _ask(study: optuna.Study, space: SkinSpace, number: int, plan: SearchPlan) -> optuna.Trial | None:
    """The new or interrupted trial of a number; `None` if it is complete.

    Each trial has its own seed, so that a resumed search proposes the same places.
    """
    import optuna

    study.sampler = _sampler(plan.sampler, child_seed(plan.seed, "skin", number) % 2**32)
    there = study.get_trials(deepcopy=False)[number : number + 1]
    if there and there[0].state.name == "COMPLETE":
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        begun = there and there[0].state.name == "RUNNING"
        trial = optuna.trial.Trial(study, there[0]._trial_id) if begun else study.ask()
        for name, (low, high) in space.ranges.items():
            trial.suggest_float(name, low, high)
        if len(space.materials) > 1:
            trial.suggest_categorical("material", space.materials)
    return trial


def _sampler(kind: Sampler, seed: int) -> optuna.samplers.BaseSampler:
    import optuna

    if kind == "random":
        return optuna.samplers.RandomSampler(seed=seed)
    return optuna.samplers.GPSampler(seed=seed, n_startup_trials=_STARTUP)


def _report(study: optuna.Study, trial: optuna.Trial, found: Evaluation) -> None:
    """Store an evaluation in the journal."""
    for name, value in found.violations.items():
        trial.set_constraint(name, value)
    trial.set_user_attr("violations", dict(found.violations))
    trial.set_user_attr("note", dict(found.record))
    study.tell(trial, list(found.values))


def _evaluation(trial: optuna.trial.FrozenTrial) -> Evaluation:
    values, attributes = tuple(trial.values or ()), trial.user_attrs
    return Evaluation(values, attributes["violations"], attributes["note"])
