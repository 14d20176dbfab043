"""Do tasks on worker processes: the longest way to the end first, a failure stops only what hangs on it."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field

from palpate.core import ArtefactStore
from palpate.study.observer import Observer
from palpate.study.task import Task
from palpate.study.worker import Outcome, begin_worker, perform, single_threaded

WORKER_DIED = "its worker process died, perhaps for want of memory"


@dataclass
class Schedule:
    """The tasks still to be done, and how the others ended.

    Attributes
    ----------
    waiting
        Tasks not yet given to a worker, by key.
    made
        Keys of the artefacts that exist.
    outcomes
        How each attempted task ended, by key.
    """

    waiting: dict[str, Task]
    made: set[str]
    outcomes: dict[str, Outcome] = field(default_factory=dict)

    def take(self) -> Task | None:
        """Take the ready task with the longest way to the end; `None` where none is ready now."""
        ready = [task for task in self.waiting.values() if self._is_ready(task)]
        if not ready:
            return None
        ways = self._ways()
        longest = max(ready, key=lambda task: ways[task.recipe.key])
        return self.waiting.pop(longest.recipe.key)

    def close(self, task: Task, outcome: Outcome) -> Iterator[tuple[Task, Outcome]]:
        """Note how a task ended, and end all that hang on a failed one; yields each with its outcome."""
        self.outcomes[task.recipe.key] = outcome
        yield task, outcome
        if not outcome.reason:
            self.made.add(task.recipe.key)
            return
        key = task.recipe.key
        hanging = [later for later in self.waiting.values() if key in {need.recipe.key for need in later.needs}]
        for later in hanging:
            if self.waiting.pop(later.recipe.key, None) is not None:
                reason = outcome.reason if task.needs else f"{task.name} failed: {outcome.reason}"
                yield from self.close(later, Outcome(reason=reason, trace="", seconds=0.0))

    def _ways(self) -> dict[str, float]:
        """Cost of each waiting task and of the longest chain that hangs on it, s, by key."""
        ways: dict[str, float] = {}
        for task in reversed(self.waiting.values()):  # each after those it needs, so backwards
            key = task.recipe.key
            ways[key] = ways.get(key, 0.0) + task.cost
            for need in task.needs:
                ways[need.recipe.key] = max(ways.get(need.recipe.key, 0.0), ways[key])
        return ways

    def _is_ready(self, task: Task) -> bool:
        return all(need.recipe.key in self.made for need in task.needs)


def do_tasks(
    tasks: Iterable[Task], made: Iterable[str], store: ArtefactStore, workers: int, observer: Observer
) -> dict[str, Outcome]:
    """Do tasks, each as soon as its inputs exist.

    Parameters
    ----------
    tasks
        What is to be done, each task after those it needs.
    made
        Keys of the artefacts that exist already.
    store
        Where artefacts are read and written.
    workers
        Number of processes, each with one thread.
    observer
        Told of every start and end.

    Returns
    -------
    dict
        How each task ended, by the key of its recipe.
    """
    schedule = Schedule(waiting={task.recipe.key: task for task in tasks}, made=set(made))
    while schedule.waiting:
        with _pool(min(workers, len(schedule.waiting))) as pool:
            _feed(pool, schedule, store, workers, observer)
    return schedule.outcomes


def _feed(
    pool: ProcessPoolExecutor, schedule: Schedule, store: ArtefactStore, workers: int, observer: Observer
) -> None:
    """Keep every worker busy until nothing is left, or until a worker dies and the pool with it."""
    running: dict[Future[Outcome], Task] = {}
    broken = False
    while True:
        while not broken and len(running) < workers and (task := schedule.take()) is not None:
            observer.started(task.name)
            running[pool.submit(perform, task, store)] = task
        if not running:
            return
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            task = running.pop(future)
            try:
                outcome = future.result()
            except BrokenProcessPool:
                broken, outcome = True, Outcome(reason=WORKER_DIED, trace="", seconds=0.0)
            for ended, how in schedule.close(task, outcome):
                observer.ended(ended.name, ended.cost, how.seconds, how.reason)


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """A pool whose processes are ended at once when the block is left by an error or Ctrl-C."""
    with single_threaded():
        pool = ProcessPoolExecutor(
            workers,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=begin_worker,
            initargs=(os.getpid(),),
        )
        before = set(multiprocessing.active_children())
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()) - before:
                process.kill()
            raise
        pool.shutdown()
