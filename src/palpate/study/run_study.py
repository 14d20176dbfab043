"""Run of a study: the module that connects the stages."""

from __future__ import annotations

import importlib.util
import json
import os
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from palpate.core import ArtefactStore, MissingExtraError, PalpateError, wrap_write_errors
from palpate.core.run import LocalWorkers, Outcome, Progress, Status, WorkerPool
from palpate.learn import find_device
from palpate.study.accuracy_task import export_twins
from palpate.study.available import default_workers
from palpate.study.cluster import ClusterWorkers
from palpate.study.collect import collect_bounds, collect_designs
from palpate.study.force_task import ForceTask
from palpate.study.plan import plan_study, with_dependencies
from palpate.study.result import DesignBounds, StudyResult, TaskFailure
from palpate.study.schedule import MOST_REMADE, Made, run_task_graph
from palpate.study.study import Study
from palpate.study.task import EstimatorTask, Task

TRACES = "failures.log"
"""File in the result folder with failures of the last run, and tracebacks of unexpected errors."""

FAILURES = "failures.json"
"""Failures of the last run as JSON: task and reason."""


def run_study(
    study: Study,
    out: Path,
    workers: int | None = None,
    progress: Progress | None = None,
    limit_s: float | None = None,
    cluster: str | None = None,
) -> StudyResult:
    """Run all designs of `study` through all stages.

    Artefacts of earlier runs in ``out/store`` are reused: an interrupted study resumes, and a finished one is only
    read.

    Parameters
    ----------
    study
        The study.
    out
        Result folder; artefacts go to ``out/store``.
    workers
        Number of worker processes; without one, one per core that has memory for it.
    progress
        Receives the start and end of every task; costs are expected seconds on one core.
    limit_s
        Time limit of a task, s; by default an hour and 200 times its expected cost.
    cluster
        Dask cluster instead of `workers`: ``"local:N"`` or ``"tcp://HOST:PORT"``.

    Returns
    -------
    StudyResult
        One record a design. Failed tasks are in `failures` and in the records of their designs; the rest is complete.

    Raises
    ------
    PalpateError
        If a design cannot be built, the folder cannot be written, its disk is full, or a library that a task needs
        is not installed.
    """
    started = time.perf_counter()
    plan = plan_study(resolve_device(study))
    run = Run(ensure_writable(out), plan.tasks(), WorkerOptions(workers, limit_s, cluster), progress)
    run.run()
    run.verify_outputs(plan.read_at_the_end())
    outcomes = run.outcomes
    run.write_failures()
    if study.built and "built" in study.model_fields_set:
        made = {built.design.skin_spec: run.store.find(built.twin.recipe) for built in plan.built if built}
        export_twins(out, ((skin, path) for skin, path in made.items() if path is not None))
    names = {task.recipe.key: task.name for task in run.tasks}
    kinds = {task.recipe.key: task.recipe.kind for task in run.tasks}
    return StudyResult(
        name=study.name,
        designs=collect_designs(plan, run.store, outcomes, study.seed),
        failures=tuple(
            TaskFailure(names[key], how.reason)
            for key, how in outcomes.items()
            if how.reason and kinds[key] not in ("twin", "built")  # of these the design says why
        ),
        computed=Counter(kinds[key] for key, how in outcomes.items() if how.value is Made.MADE),
        reused=Counter(kinds[key] for key in run.made | run.found()),
        wall_s=time.perf_counter() - started,
    )


def run_bounds(
    study: Study, out: Path, workers: int | None = None, progress: Progress | None = None
) -> tuple[DesignBounds, ...]:
    """Bound the errors of every design of `study` without training; missing presses are solved.

    Parameters and errors are those of `run_study`, whose artefacts are used and made.

    Returns
    -------
    tuple[DesignBounds, ...]
        One record a design, in the order of the study.
    """
    plan = plan_study(study)
    run = Run(ensure_writable(out), plan.bound_tasks(), WorkerOptions(workers), progress)
    run.run()
    run.verify_outputs(tuple(design.bound for design in plan.designs))
    run.write_failures()
    return collect_bounds([design.bound for design in plan.designs], run.store, run.outcomes)


def run_tasks(
    out: Path, tasks: Sequence[Task], workers: int | None = None, progress: Progress | None = None, cluster: str = ""
) -> dict[str, str]:
    """Run tasks in the order of their dependencies; artefacts of earlier runs in ``out/store`` are reused.

    Returns
    -------
    dict[str, str]
        Reasons of the failed ones among `tasks`, by the key of their recipe; failed dependencies are named.

    Raises
    ------
    PalpateError
        If the folder cannot be written.
    """
    run = Run(
        ensure_writable(out),
        with_dependencies(tasks),
        WorkerOptions(workers, None, cluster or None),
        progress,
    )
    run.run()
    run.write_failures()
    reasons = {task.recipe.key: next(filter(None, map(run.reason, with_dependencies([task]))), "") for task in tasks}
    return {key: reason for key, reason in reasons.items() if reason}


def resolve_device(study: Study) -> Study:
    """Return the study with its training device resolved, since it affects the estimators."""
    device = find_device(study.learning.device)
    return study.model_copy(update={"learning": study.learning.model_copy(update={"device": device})})


@dataclass(frozen=True)
class WorkerOptions:
    """Workers of the tasks, and time limit of each; see `run_study`."""

    workers: int | None = None
    limit_s: float | None = None
    cluster: str | None = None

    def make_pool(self, tasks: int) -> WorkerPool:
        """Make a pool of workers for this number of tasks."""
        if self.cluster is not None:
            return ClusterWorkers(self.cluster)
        return LocalWorkers(min(self.workers or default_workers(), tasks))


class Run:
    """One run of the tasks of a study: existing artefacts, and outcomes of the remaining tasks."""

    def __init__(
        self, out: Path, tasks: tuple[Task, ...], worker_options: WorkerOptions, progress: Progress | None
    ) -> None:
        self.out, self.tasks = out, tasks
        self.store = ArtefactStore(out / "store")
        self.outcomes: dict[str, Outcome] = {}
        self.made = {task.recipe.key for task in tasks if self.store.has(task.recipe, task.suffix)}
        self._workers, self._progress = worker_options, progress or Progress()

    def run(self) -> None:
        """Run the tasks whose artefacts are missing."""
        todo = [task for task in self.tasks if task.recipe.key not in self.made]
        text = f"{len(todo)} artefacts to make, {len(self.made)} found"
        self._progress.plan(sum(task.cost for task in todo), text)
        self._do(todo)

    def verify_outputs(self, read: Sequence[Task]) -> None:
        """Verify existing artefacts that are read at the end; broken ones are made again."""
        for _ in range(MOST_REMADE):
            broken = [
                task
                for task in read
                if task.recipe.key in self.made and self.store.find(task.recipe, task.suffix) is None
            ]
            if not broken:
                return
            self._do(broken)

    def found(self) -> set[str]:
        """Keys of artefacts that another run has made in the meantime."""
        return {key for key, how in self.outcomes.items() if how.value is Made.FOUND}

    def reason(self, task: Task) -> str:
        """Reason why a task failed in this run; empty if it did not."""
        how = self.outcomes.get(task.recipe.key)
        return f"{task.name}: {how.reason}" if how is not None and how.reason else ""

    def write_failures(self) -> None:
        """Write the failures of this run into the result folder, replacing those of an earlier one."""
        named = [(task, self.outcomes[task.recipe.key]) for task in self.tasks if task.recipe.key in self.outcomes]
        failed = [(task.name, how) for task, how in named if how.reason]
        listed = [{"task": name, "reason": how.reason} for name, how in failed]
        with suppress(OSError):  # the disk may be full; the result carries the failures as well
            if not failed:
                (self.out / TRACES).unlink(missing_ok=True)
                (self.out / FAILURES).unlink(missing_ok=True)
                return
            (self.out / TRACES).write_text("\n".join(f"{name}: {how.reason}\n{how.trace}" for name, how in failed))
            (self.out / FAILURES).write_text(json.dumps(listed, indent=2) + "\n")

    def _do(self, todo: Sequence[Task]) -> None:
        if not todo:
            return
        if any(isinstance(task, EstimatorTask | ForceTask) for task in todo):
            _refuse_missing_libraries()
        self.made -= {task.recipe.key for task in todo}
        store = ArtefactStore(self.store.root.resolve())  # workers of a cluster have other working folders
        with self._workers.make_pool(len(todo)) as pool:
            made = self.made | {key for key, how in self.outcomes.items() if not how.reason}
            outcomes = run_task_graph(todo, made, pool, store, self._progress, self._workers.limit_s)
        self.outcomes.update(outcomes)
        self.made -= outcomes.keys()  # what broke while it was read was made again
        full = next((how for how in outcomes.values() if how.status is Status.UNWRITABLE), None)
        if full is not None:
            self.write_failures()
            problem = (full.error.problem if full.error else full.reason).rstrip(".")
            raise PalpateError(
                f"A task could not write its result: {problem}.",
                "Choose another folder, or free some space.",
                code="disk-unwritable",
            )


def ensure_writable(out: Path) -> Path:
    """Make the result folder and return it; raise a `PalpateError` if it is not writable."""
    with wrap_write_errors(f"The result folder {out}", "Choose another with --out."):
        out.mkdir(parents=True, exist_ok=True)
        probe = out / f".writable-{os.getpid()}"
        probe.touch()
        probe.unlink()
    return out


def _refuse_missing_libraries() -> None:
    for library in ("torch", "optuna", "onnx"):
        if importlib.util.find_spec(library) is None:
            raise MissingExtraError(library, "learn")
