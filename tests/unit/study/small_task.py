"""Small tasks with real files, that fail on demand, and a pool that does them."""

import os
import signal
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from palpate.core import ArtefactStore, PalpateError, Recipe
from palpate.core.run import LocalWorkers, Outcome, Progress
from palpate.study.schedule import run_task_graph
from palpate.study.task import Task, find_artefact

_CREWS: dict[int, LocalWorkers] = {}
"""Workers at work for tests, by their number: a start of one takes seconds."""


@dataclass(frozen=True)
class Sum(Task):
    """Adds the numbers of the tasks it needs to its own; or fails on demand."""

    label: str
    number: float
    after: tuple["Sum", ...] = ()
    fault: str = ""
    seconds: float = 1.0
    lasts: float = 0.0
    """How long it takes, s."""

    @property
    def name(self) -> str:
        return self.label

    @property
    def recipe(self) -> Recipe:
        inputs = tuple(task.recipe.key for task in self.after)
        return Recipe(kind="sum", spec=[self.label, self.number], inputs=inputs)

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return self.after

    @property
    def cost(self) -> float:
        return self.seconds

    def make(self, store: ArtefactStore) -> None:
        log(store, self.label)
        time.sleep(self.lasts)
        self._fail(store)
        total = self.number + sum(float(find_artefact(store, task).read_text()) for task in self.after)
        store.write(self.recipe, lambda path: write_text(path, str(total)))

    def _fail(self, store: ArtefactStore) -> None:
        if self.fault == "foreseen":
            raise PalpateError("The wall is too thin.", "Take 2 mm.", code="wall-too-thin")
        if self.fault == "unforeseen":
            raise KeyError("tilt")
        if self.fault == "killed" or (self.fault == "killed once" and starts(store, self.label) == 1):
            os.kill(os.getpid(), signal.SIGKILL)
        if self.fault == "hung":
            hang_here()


def hang_here() -> None:
    """Stand still longer than any test waits."""
    time.sleep(1000)


def log(store: ArtefactStore, label: str) -> None:
    """Note beside the store that a task was started; appended whole, so that several processes may."""
    with (store.root / "starts.log").open("a") as file:
        file.write(label + "\n")


def starts(store: ArtefactStore, label: str) -> int:
    """How often a task was started."""
    return (store.root / "starts.log").read_text().splitlines().count(label)


def write_text(path: Path, text: str) -> None:
    path.write_text(text)


def read(store: ArtefactStore, task: Task) -> float:
    """The number in a finished artefact."""
    return float(find_artefact(store, task).read_text())


def do(
    tasks: Iterable[Task],
    made: Iterable[str],
    store: ArtefactStore,
    workers: int,
    progress: Progress | None = None,
    limit_s: float | None = None,
) -> dict[str, Outcome]:
    """Do tasks on processes of this machine, those of `crew`."""
    return run_task_graph(tasks, made, crew(workers), store, progress, limit_s)


def crew(workers: int) -> LocalWorkers:
    """Workers that stay awake from test to test, until `end_crews`; one that died is replaced."""
    if workers not in _CREWS:
        _CREWS[workers] = LocalWorkers(workers)
    return _CREWS[workers]


def end_crews() -> None:
    """End the workers of `crew`: at the end of every module that lets them do tasks."""
    while _CREWS:
        _CREWS.popitem()[1].shutdown()
