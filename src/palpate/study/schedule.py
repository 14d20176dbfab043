"""Order of tasks: longest remaining path first; a failure stops only the tasks that depend on it."""

from __future__ import annotations

import heapq
import time
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import StrEnum

from palpate.core import ArtefactStore
from palpate.core.run import Call, Outcome, Progress, Status, WorkerPool
from palpate.study.task import MissingArtefactError, Task

MOST_REMADE = 2
"""Maximum number of times that a broken artefact is made again in one run. By hand."""

BUSY_S = 1.0
"""Time between two looks at an artefact that another run makes, s. By hand."""


NEVER_CAME = "an artefact that it needs is neither there nor to be made"

LEAST_LIMIT_S, LIMIT_OVER_COST = 3600.0, 200.0
"""Default time limit of a task: the sum of this time and this multiple of its expected cost. By hand."""


def time_limit(task: Task) -> float:
    """Default time limit of a task, s."""
    return LEAST_LIMIT_S + LIMIT_OVER_COST * task.cost


class Made(StrEnum):
    """Result of a task that succeeded."""

    MADE = "made"
    FOUND = "found"
    """Reason: another run made the artefact in the meantime."""
    BUSY = "busy"
    """Reason: another run makes the artefact now."""


def run_task(task: Task, store: ArtefactStore, progress: Progress) -> Made:
    """Make the artefact of a task under its lease, unless another run has made it or makes it now."""
    with store.lease(task.recipe) as free:
        if not free:
            return Made.BUSY
        if store.has(task.recipe, task.suffix):
            return Made.FOUND
        task.make(store)
    return Made.MADE


class Schedule:
    """Remaining tasks, and outcomes of the completed ones.

    Parameters
    ----------
    tasks
        Tasks to run, each after its dependencies.
    made
        Keys of the artefacts that exist.
    """

    def __init__(self, tasks: Iterable[Task], made: Iterable[str]) -> None:
        self.made = set(made)
        self.outcomes: dict[str, Outcome] = {}
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
        """Take the ready task with the longest remaining path; `None` if no task is ready."""
        while self._ready:
            task = self._waiting.get(heapq.heappop(self._ready)[2])
            if task is not None and not self._lacking[task.recipe.key]:
                return self._waiting.pop(task.recipe.key)
        return None

    def complete(self, task: Task, outcome: Outcome) -> Iterator[tuple[Task, Outcome]]:
        """Record the outcome of a task, and end all that depend on a failed one; yield each with its outcome."""
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
                yield from self.complete(hanging, Outcome(reason=reason, status=Status.FAILED))

    def cancel_all(self, reason: str) -> Iterator[tuple[Task, Outcome]]:
        """End every waiting task for one reason; yield each with its outcome."""
        while self._waiting:
            task = self._waiting.pop(next(iter(self._waiting)))
            yield from self.complete(task, Outcome(reason=reason, status=Status.FAILED))

    def remake(self, task: Task, missing: str) -> bool:
        """Schedule a broken artefact that `task` needs to be made again, and the task after it.

        Returns
        -------
        bool
            Whether this is allowed: the artefact broke at most `MOST_REMADE` times.
        """
        need = next((need for need in task.dependencies if need.recipe.key == missing), None)
        if need is None or (missing in self.outcomes and self.outcomes[missing].reason):
            return False
        if missing in self.made:
            if self._remade[missing] >= MOST_REMADE:
                return False
            self._remade[missing] += 1
            self.made.discard(missing)
            self._ways.setdefault(missing, self._ways[task.recipe.key] + need.urgency)
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
    """Running tasks, and those to be tried again.

    Attributes
    ----------
    running
        Tasks given to the pool, by their calls.
    begun
        Keys of the tasks whose progress has begun.
    busy
        Tasks that another run makes, with the time of the next look.
    suspects
        Tasks whose worker died; each is tried once more, alone, since the memory may have been too small for several.
    tried
        Number of dead workers of a task, by key.
    alone
        Whether the running task must be the only one.
    """

    running: dict[Call, Task] = field(default_factory=dict)
    begun: set[str] = field(default_factory=set)
    busy: deque[tuple[float, Task]] = field(default_factory=deque)
    suspects: deque[Task] = field(default_factory=deque)
    tried: Counter[str] = field(default_factory=Counter)
    alone: bool = False

    def begin(self, task: Task, progress: Progress) -> None:
        """Begin the progress of a task, unless it has begun."""
        if task.recipe.key not in self.begun:
            self.begun.add(task.recipe.key)
            progress.begin(task.name, task.cost)

    def finish(self, ended: Iterable[tuple[Task, Outcome]], progress: Progress) -> None:
        """End the progress of tasks; those that were never given to the pool are no longer planned."""
        for task, outcome in ended:
            if task.recipe.key in self.begun:
                self.begun.discard(task.recipe.key)
                progress.finish(task.name, outcome.reason)
            else:
                progress.total -= task.cost


def run_task_graph(
    tasks: Iterable[Task],
    made: Iterable[str],
    pool: WorkerPool,
    store: ArtefactStore,
    progress: Progress | None = None,
    limit_s: float | None = None,
) -> dict[str, Outcome]:
    """Run tasks, each as soon as its inputs exist.

    Parameters
    ----------
    tasks
        Tasks to run, each after its dependencies.
    made
        Keys of the artefacts that exist already.
    pool
        Worker pool.
    store
        Store of the artefacts.
    progress
        Receives every start and end.
    limit_s
        Time limit of a task, s; by default that of `time_limit`.

    Returns
    -------
    dict
        Outcome of each task, by the key of its recipe, including artefacts that were made again.
    """
    schedule, work, progress = Schedule(tasks, made), RunningTasks(), progress or Progress()
    while True:
        while (task := _next(schedule, work, pool.size)) is not None:
            work.begin(task, progress)
            limit = time_limit(task) if limit_s is None else limit_s
            work.running[pool.submit(run_task, task, store, limit_s=limit)] = task
        if not work.running and not work.busy:
            work.finish(schedule.cancel_all(NEVER_CAME), progress)
            return schedule.outcomes
        for call, outcome in pool.wait():
            work.finish(_settle(schedule, work, work.running.pop(call), outcome), progress)


def _next(schedule: Schedule, work: RunningTasks, size: int) -> Task | None:
    """Return the next task for a free member."""
    if len(work.running) >= size or (work.alone and work.running):
        return None
    work.alone = False
    task = schedule.next_task()
    if task is None and work.busy and work.busy[0][0] <= time.monotonic():
        task = work.busy.popleft()[1]
    if task is None and work.suspects and not work.running and not work.busy:
        task, work.alone = work.suspects.popleft(), True
    return task


def _settle(schedule: Schedule, work: RunningTasks, task: Task, outcome: Outcome) -> Iterator[tuple[Task, Outcome]]:
    """Record a member's report; yield the tasks that end by it, each with its outcome."""
    key = task.recipe.key
    if outcome.value is Made.BUSY:
        work.busy.append((time.monotonic() + BUSY_S, task))
    elif isinstance(outcome.error, MissingArtefactError) and schedule.remake(task, outcome.error.key):
        return
    elif outcome.status is Status.DIED and not work.tried[key]:
        work.tried[key] += 1
        work.suspects.append(task)
    elif outcome.status is Status.DIED:
        reason = f"{outcome.reason}; tried once more alone, it died again"
        yield from schedule.complete(task, replace(outcome, reason=reason))
    else:
        yield from schedule.complete(task, outcome)
        if outcome.status is Status.UNWRITABLE:
            yield from _give_up(schedule, work, f"not tried: {outcome.reason}")


def _give_up(schedule: Schedule, work: RunningTasks, reason: str) -> Iterator[tuple[Task, Outcome]]:
    """End all tasks that are not running."""
    for task in (*work.suspects, *(task for _, task in work.busy)):
        yield from schedule.complete(task, Outcome(reason=reason, status=Status.FAILED))
    work.suspects.clear()
    work.busy.clear()
    yield from schedule.cancel_all(reason)


def _ways(tasks: list[Task]) -> dict[str, float]:
    """Return the urgency of each task and of the longest chain that depends on it, by key."""
    ways: dict[str, float] = {}
    for task in reversed(tasks):  # each after those it needs, so backwards
        key = task.recipe.key
        ways[key] = ways.get(key, 0.0) + task.urgency
        for need in task.dependencies:
            ways[need.recipe.key] = max(ways.get(need.recipe.key, 0.0), ways[key])
    return ways
