"""In which order tasks are done: the longest way to the end first, a failure stops only what depends on it."""

from __future__ import annotations

import heapq
import time
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from palpate.study.observer import Observer
from palpate.study.task import Task
from palpate.study.worker import TaskOutcome, TaskStatus
from palpate.study.worker_pool import WorkerPool

MOST_REMADE = 2
"""How often in one run an artefact that breaks again and again is made again."""

BUSY_S = 1.0
"""When to look again at an artefact that another run makes, s."""

POLL_S = 0.5
"""How often the time of the tasks at work is looked at, s."""

NEVER_CAME = "an artefact that it needs is neither there nor to be made"

LEAST_LIMIT_S, LIMIT_OVER_COST = 3600.0, 200.0
"""A task is given this time, and this many times its expected cost, before it is taken for hung."""


def time_limit(task: Task) -> float:
    """How long a task may take where nobody says otherwise, s."""
    return LEAST_LIMIT_S + LIMIT_OVER_COST * task.cost


class Schedule:
    """The tasks still to be done, and how the others ended.

    Parameters
    ----------
    tasks
        What is to be done, each task after those it needs.
    made
        Keys of the artefacts that exist.
    """

    def __init__(self, tasks: Iterable[Task], made: Iterable[str]) -> None:
        self.made = set(made)
        self.outcomes: dict[str, TaskOutcome] = {}
        self._waiting: dict[str, Task] = {}
        self._lacking: dict[str, set[str]] = {}
        self._hanging: dict[str, list[str]] = {}
        self._ready: list[tuple[float, int, str]] = []
        self._remade: Counter[str] = Counter()
        self._order = 0
        tasks = list(tasks)
        self._ways = _ways(tasks)
        for task in tasks:
            self._add(task)

    def next_task(self) -> Task | None:
        """Take the ready task with the longest way to the end; `None` where none is ready now."""
        while self._ready:
            task = self._waiting.get(heapq.heappop(self._ready)[2])
            if task is not None and not self._lacking[task.recipe.key]:
                return self._waiting.pop(task.recipe.key)
        return None

    def complete(self, task: Task, outcome: TaskOutcome) -> Iterator[tuple[Task, TaskOutcome]]:
        """Note how a task ended, and end all that depend on a failed one; yields each with its outcome."""
        key = task.recipe.key
        self.outcomes[key] = outcome
        yield task, outcome
        if not outcome.reason:
            self.made.add(key)
            for later in self._hanging.pop(key, []):
                self._lacking[later].discard(key)
                self._push(later)
            return
        reason = outcome.reason if task.dependencies else f"{task.name} failed: {outcome.reason}"
        for later in self._hanging.pop(key, []):
            if (hanging := self._waiting.pop(later, None)) is not None:
                yield from self.complete(hanging, TaskOutcome(reason, "", 0.0, TaskStatus.FAILED))

    def cancel_all(self, reason: str) -> Iterator[tuple[Task, TaskOutcome]]:
        """End every waiting task for one reason; yields each with its outcome."""
        while self._waiting:
            task = self._waiting.pop(next(iter(self._waiting)))
            yield from self.complete(task, TaskOutcome(reason, "", 0.0, TaskStatus.FAILED))

    def remake(self, task: Task, missing: str) -> bool:
        """Let an artefact that `task` needs and that broke be made again, and the task after it.

        Returns
        -------
        bool
            Whether it may; not where it broke more than `MOST_REMADE` times.
        """
        need = next((need for need in task.dependencies if need.recipe.key == missing), None)
        if need is None or (missing in self.outcomes and self.outcomes[missing].reason):
            return False
        if missing in self.made:
            if self._remade[missing] >= MOST_REMADE:
                return False
            self._remade[missing] += 1
            self.made.discard(missing)
            self._ways.setdefault(missing, self._ways[task.recipe.key] + need.cost)
            self._add(need)
        self._add(task)
        return True

    def _add(self, task: Task) -> None:
        key = task.recipe.key
        self._waiting[key] = task
        self._lacking[key] = {need.recipe.key for need in task.dependencies} - self.made
        for lacking in self._lacking[key]:
            self._hanging.setdefault(lacking, []).append(key)
        self._push(key)

    def _push(self, key: str) -> None:
        if not self._lacking[key]:
            self._order += 1
            heapq.heappush(self._ready, (-self._ways[key], self._order, key))


@dataclass
class RunningTasks:
    """What is at work now, and what has to be tried again.

    Attributes
    ----------
    running
        Tasks given to a crew, by key, with the time at which they are taken for hung (s of the monotonic clock).
    busy
        Tasks that another run does, with the time at which to look again.
    suspects
        Tasks whose worker died; each is tried once more, alone, for the memory may have been too small for several.
    tried
        How often the worker of a task died, by key.
    stopped
        Tasks that were taken for hung, by key, with their time, s.
    alone
        Whether the task at work must have no other beside it.
    """

    running: dict[str, tuple[Task, float]] = field(default_factory=dict)
    busy: deque[tuple[float, Task]] = field(default_factory=deque)
    suspects: deque[Task] = field(default_factory=deque)
    tried: Counter[str] = field(default_factory=Counter)
    stopped: dict[str, float] = field(default_factory=dict)
    alone: bool = False


def run_task_graph(
    tasks: Iterable[Task], made: Iterable[str], pool: WorkerPool, observer: Observer, limit_s: float | None = None
) -> dict[str, TaskOutcome]:
    """Do tasks, each as soon as its inputs exist.

    Parameters
    ----------
    tasks
        What is to be done, each task after those it needs.
    made
        Keys of the artefacts that exist already.
    pool
        Who does them.
    observer
        Called at every start and end.
    limit_s
        How long a task may take, s; without it, as `time_limit` says.

    Returns
    -------
    dict
        How each task ended, by the key of its recipe. What was broken and made again is among them.
    """
    schedule, work = Schedule(tasks, made), RunningTasks()
    while True:
        while (task := _next(schedule, work, pool.size)) is not None:
            observer.started(task.name)
            limit = time_limit(task) if limit_s is None else limit_s
            work.running[task.recipe.key] = (task, time.monotonic() + limit)
            pool.submit(task)
        if not work.running and not work.busy:
            for ended, how in schedule.cancel_all(NEVER_CAME):
                observer.ended(ended.name, ended.cost, how.seconds, how.reason)
            return schedule.outcomes
        for task, outcome in pool.wait(POLL_S):
            del work.running[task.recipe.key]
            for ended, how in _settle(schedule, work, task, outcome):
                observer.ended(ended.name, ended.cost, how.seconds, how.reason)
        _stop_hung(work, pool, limit_s)


def _next(schedule: Schedule, work: RunningTasks, size: int) -> Task | None:
    """The next task to give to a free member."""
    if len(work.running) >= size or (work.alone and work.running):
        return None
    work.alone = False
    task = schedule.next_task()
    if task is None and work.busy and work.busy[0][0] <= time.monotonic():
        task = work.busy.popleft()[1]
    if task is None and work.suspects and not work.running and not work.busy:
        task, work.alone = work.suspects.popleft(), True
    return task


def _settle(
    schedule: Schedule, work: RunningTasks, task: Task, outcome: TaskOutcome
) -> Iterator[tuple[Task, TaskOutcome]]:
    """Take what a member reported; yields the tasks that are over by it, each with its outcome."""
    key = task.recipe.key
    if outcome.ended is TaskStatus.BUSY:
        work.busy.append((time.monotonic() + BUSY_S, task))
    elif outcome.ended is TaskStatus.MISSING and schedule.remake(task, outcome.missing):
        return
    elif outcome.ended is TaskStatus.DIED and key in work.stopped:
        reason = f"it took longer than {work.stopped[key]:g} s and was stopped"
        yield from schedule.complete(task, TaskOutcome(reason, outcome.trace, work.stopped[key], TaskStatus.FAILED))
    elif outcome.ended is TaskStatus.DIED and not work.tried[key]:
        work.tried[key] += 1
        work.suspects.append(task)
    elif outcome.ended is TaskStatus.DIED:
        reason = f"{outcome.reason}; tried once more alone, it died again"
        yield from schedule.complete(task, TaskOutcome(reason, outcome.trace, outcome.seconds, TaskStatus.FAILED))
    else:
        yield from schedule.complete(task, outcome)
        if outcome.ended is TaskStatus.UNWRITABLE:
            yield from _give_up(schedule, work, f"not tried: {outcome.reason}")


def _give_up(schedule: Schedule, work: RunningTasks, reason: str) -> Iterator[tuple[Task, TaskOutcome]]:
    """End all that is not at work now."""
    for task in (*work.suspects, *(task for _, task in work.busy)):
        yield from schedule.complete(task, TaskOutcome(reason, "", 0.0, TaskStatus.FAILED))
    work.suspects.clear()
    work.busy.clear()
    yield from schedule.cancel_all(reason)


def _stop_hung(work: RunningTasks, crew: WorkerPool, limit_s: float | None) -> None:
    now = time.monotonic()
    for key, (task, until) in work.running.items():
        if now > until and key not in work.stopped:
            work.stopped[key] = time_limit(task) if limit_s is None else limit_s
            crew.cancel(task)


def _ways(tasks: list[Task]) -> dict[str, float]:
    """Cost of each task and of the longest chain that depends on it, s, by key."""
    ways: dict[str, float] = {}
    for task in reversed(tasks):  # each after those it needs, so backwards
        key = task.recipe.key
        ways[key] = ways.get(key, 0.0) + task.cost
        for need in task.dependencies:
            ways[need.recipe.key] = max(ways.get(need.recipe.key, 0.0), ways[key])
    return ways
