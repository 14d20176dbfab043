"""Run a study: the only place where the stages meet."""

from __future__ import annotations

import importlib.util
import os
import time
from collections import Counter
from pathlib import Path

from palpate.core import ArtefactStore, MissingExtraError, PalpateError
from palpate.learn import find_device
from palpate.study.collect import collect_designs, collect_limits
from palpate.study.observer import Observer, Silence
from palpate.study.plan import plan_study
from palpate.study.result import DesignLimits, StudyResult, TaskFailure
from palpate.study.schedule import do_tasks
from palpate.study.study import Study
from palpate.study.task import EstimatorTask, Task
from palpate.study.worker import Outcome

TRACES = "failures.log"
"""File in the result folder with the tracebacks of errors that nobody foresaw."""


def run_study(study: Study, out: Path, workers: int | None = None, observer: Observer | None = None) -> StudyResult:
    """Carry every design of `study` through the whole chain.

    What an earlier run left in ``out/store`` is used, so an interrupted study goes on where it was and a
    finished one is only read.

    Parameters
    ----------
    study
        The study.
    out
        Result folder; artefacts go to ``out/store``.
    workers
        Number of worker processes; without one, as many as there are cores.
    observer
        Told how it goes.

    Returns
    -------
    StudyResult
        One record a design. A task that failed is in `failures`; its designs say so and the rest is complete.

    Raises
    ------
    PalpateError
        If a design cannot be built, the folder cannot be written, or a library for what is still to be done
        is not installed.
    """
    started = time.perf_counter()
    observer = observer or Silence()
    plan = plan_study(_on_its_device(study))
    tasks = plan.tasks()
    store = ArtefactStore(_writable(out) / "store")
    made, todo = _sort_out(tasks, store)
    outcomes = _do(todo, made, store, workers, observer)
    _write_traces(out / TRACES, todo, outcomes)
    names = {task.recipe.key: task.name for task in tasks}
    return StudyResult(
        name=study.name,
        designs=collect_designs(plan.designs, store, outcomes, study.seed),
        failures=tuple(TaskFailure(names[key], how.reason) for key, how in outcomes.items() if how.reason),
        computed=Counter(task.recipe.kind for task in todo if not outcomes[task.recipe.key].reason),
        reused=Counter(task.recipe.kind for task in tasks if task.recipe.key in made),
        wall_s=time.perf_counter() - started,
    )


def run_limits(
    study: Study, out: Path, workers: int | None = None, observer: Observer | None = None
) -> tuple[DesignLimits, ...]:
    """Bound the errors of every design of `study`, without any training; missing presses are solved.

    Parameters and errors are those of `run_study`, whose artefacts are used and made.

    Returns
    -------
    tuple[DesignLimits, ...]
        One record a design, in the order of the study.
    """
    plan = plan_study(study)
    store = ArtefactStore(_writable(out) / "store")
    made, todo = _sort_out(plan.limit_tasks(), store)
    outcomes = _do(todo, made, store, workers, observer or Silence())
    _write_traces(out / TRACES, todo, outcomes)
    return collect_limits([design.limit for design in plan.designs], store, outcomes)


def _on_its_device(study: Study) -> Study:
    """The same study with the device that it names or that this machine has: it decides the estimators' numbers."""
    device = find_device(study.learning.device)
    return study.model_copy(update={"learning": study.learning.model_copy(update={"device": device})})


def _sort_out(tasks: tuple[Task, ...], store: ArtefactStore) -> tuple[set[str], tuple[Task, ...]]:
    """Keys of the artefacts that exist, and the tasks still to be done."""
    made = {task.recipe.key for task in tasks if store.find(task.recipe, task.suffix) is not None}
    return made, tuple(task for task in tasks if task.recipe.key not in made)


def _do(
    todo: tuple[Task, ...], made: set[str], store: ArtefactStore, workers: int | None, observer: Observer
) -> dict[str, Outcome]:
    if any(isinstance(task, EstimatorTask) for task in todo):
        _refuse_missing_libraries()
    observer.planned(len(todo), len(made), sum(task.cost for task in todo))
    return do_tasks(todo, made, store, workers or available_cores(), observer)


def available_cores() -> int:
    """Number of cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


def _writable(out: Path) -> Path:
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / f".writable-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise PalpateError(
            f"The result folder {out} cannot be written: {error.strerror}.", "Choose another with --out."
        ) from error
    return out


def _refuse_missing_libraries() -> None:
    for library in ("torch", "optuna", "onnx"):
        if importlib.util.find_spec(library) is None:
            raise MissingExtraError(library, "learn")


def _write_traces(path: Path, tasks: tuple[Task, ...], outcomes: dict[str, Outcome]) -> None:
    traces = [
        f"{task.name}\n{outcomes[task.recipe.key].trace}"
        for task in tasks
        if task.recipe.key in outcomes and outcomes[task.recipe.key].trace
    ]
    if traces:
        path.write_text("\n".join(traces))
