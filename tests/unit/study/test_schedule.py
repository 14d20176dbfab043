import os
import signal
from dataclasses import dataclass
from pathlib import Path

import pytest

from palpate.core import ArtefactStore, PalpateError, Recipe
from palpate.study import Silence
from palpate.study.schedule import WORKER_DIED, do_tasks
from palpate.study.task import Task, find_made


@dataclass(frozen=True)
class Sum(Task):
    """Adds the numbers of the tasks it needs to its own; or fails as told."""

    label: str
    number: float
    after: tuple["Sum", ...] = ()
    fault: str = ""
    seconds: float = 1.0

    @property
    def name(self) -> str:
        return self.label

    @property
    def recipe(self) -> Recipe:
        inputs = tuple(task.recipe.key for task in self.after)
        return Recipe(kind="sum", spec=[self.label, self.number], inputs=inputs)

    @property
    def needs(self) -> tuple[Task, ...]:
        return self.after

    @property
    def cost(self) -> float:
        return self.seconds

    def make(self, store: ArtefactStore) -> None:
        if self.fault == "foreseen":
            raise PalpateError("The wall is too thin.", "Take 2 mm.")
        if self.fault == "unforeseen":
            raise KeyError("tilt")
        if self.fault == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        total = self.number + sum(float(find_made(store, task).read_text()) for task in self.after)
        store.write(self.recipe, lambda path: _write(path, str(total)))


def _write(path: Path, text: str) -> None:
    path.write_text(text)


class Diary(Silence):
    """Keeps the order of starts."""

    def __init__(self) -> None:
        self.starts: list[str] = []

    def started(self, task: str) -> None:
        self.starts.append(task)


@pytest.fixture
def store(tmp_path: Path) -> ArtefactStore:
    return ArtefactStore(tmp_path)


def test_tasks_run_after_what_they_need(store: ArtefactStore) -> None:
    one, two = Sum("one", 1.0), Sum("two", 2.0)
    last = Sum("last", 10.0, after=(one, two))
    outcomes = do_tasks([one, two, last], [], store, 2, Silence())
    assert [outcomes[task.recipe.key].reason for task in (one, two, last)] == ["", "", ""]
    assert find_made(store, last).read_text() == "13.0"


def test_what_exists_is_not_made_again(store: ArtefactStore) -> None:
    one = Sum("one", 1.0)
    do_tasks([one], [], store, 1, Silence())
    last = Sum("last", 10.0, after=(one,))
    outcomes = do_tasks([last], [one.recipe.key], store, 1, Silence())
    assert set(outcomes) == {last.recipe.key}


def test_the_longest_ready_task_goes_first(store: ArtefactStore) -> None:
    tasks = [Sum("short", 1.0, seconds=1), Sum("long", 1.0, seconds=9), Sum("middle", 1.0, seconds=5)]
    diary = Diary()
    do_tasks(tasks, [], store, 1, diary)
    assert diary.starts == ["long", "middle", "short"]


def test_a_short_task_that_opens_a_long_way_goes_before_a_longer_one(store: ArtefactStore) -> None:
    opener = Sum("opener", 1.0, seconds=1)
    tasks = [opener, Sum("long", 1.0, seconds=5), Sum("way", 1.0, after=(opener,), seconds=9)]
    diary = Diary()
    do_tasks(tasks, [], store, 1, diary)
    assert diary.starts == ["opener", "way", "long"]


def test_a_failure_stops_only_what_hangs_on_it(store: ArtefactStore) -> None:
    bad = Sum("bad", 1.0, fault="foreseen")
    after = Sum("after", 1.0, after=(bad,))
    last = Sum("last", 1.0, after=(after,))
    good = Sum("good", 1.0)
    outcomes = do_tasks([bad, after, last, good], [], store, 2, Silence())
    reason = "The wall is too thin. Take 2 mm."
    assert outcomes[bad.recipe.key].reason == reason
    assert outcomes[after.recipe.key].reason == outcomes[last.recipe.key].reason == f"bad failed: {reason}"
    assert outcomes[good.recipe.key].reason == ""


def test_an_unforeseen_error_keeps_its_traceback(store: ArtefactStore) -> None:
    bad = Sum("bad", 1.0, fault="unforeseen")
    outcome = do_tasks([bad], [], store, 1, Silence())[bad.recipe.key]
    assert outcome.reason == "KeyError: 'tilt'"
    assert "Traceback" in outcome.trace


def test_a_worker_that_dies_takes_only_its_task_along(store: ArtefactStore) -> None:
    bad = Sum("bad", 1.0, fault="killed", seconds=9)
    rest = [Sum(f"good {i}", 1.0) for i in range(3)]
    outcomes = do_tasks([bad, *rest], [], store, 1, Silence())
    assert outcomes[bad.recipe.key].reason == WORKER_DIED
    assert [outcomes[task.recipe.key].reason for task in rest] == ["", "", ""]
