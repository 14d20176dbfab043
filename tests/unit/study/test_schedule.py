from collections.abc import Iterator
from pathlib import Path

import pytest
from small_task import Sum, do, end_crews, read

from errors import check_values
from palpate.core import ArtefactStore
from palpate.core.run import Outcome, Progress
from palpate.study.schedule import Schedule, time_limit
from palpate.study.task import Task


class Diary(Progress):
    """Keeps the order of starts."""

    def __init__(self) -> None:
        super().__init__()
        self.starts: list[str] = []

    def begin(self, what: str, cost: float = 1.0, done: float = 0.0) -> None:
        super().begin(what, cost, done)
        self.starts.append(what)


@pytest.fixture(scope="module", autouse=True)
def crews() -> Iterator[None]:
    yield
    end_crews()


@pytest.fixture
def store(tmp_path: Path) -> ArtefactStore:
    return ArtefactStore(tmp_path)


def test_tasks_run_after_what_they_need(store: ArtefactStore) -> None:
    one, two = Sum("one", 1.0), Sum("two", 2.0)
    last = Sum("last", 10.0, after=(one, two))
    outcomes = do([one, two, last], [], store, 2)
    assert [outcomes[task.recipe.key].reason for task in (one, two, last)] == ["", "", ""]
    assert read(store, last) == 13.0


def test_what_exists_is_not_made_again(store: ArtefactStore) -> None:
    one = Sum("one", 1.0)
    do([one], [], store, 1)
    last = Sum("last", 10.0, after=(one,))
    outcomes = do([last], [one.recipe.key], store, 1)
    assert set(outcomes) == {last.recipe.key}


def test_the_longest_ready_task_goes_first(store: ArtefactStore) -> None:
    tasks = [Sum("short", 1.0, seconds=1), Sum("long", 1.0, seconds=9), Sum("middle", 1.0, seconds=5)]
    diary = Diary()
    do(tasks, [], store, 1, diary)
    assert diary.starts == ["long", "middle", "short"]


def test_a_short_task_that_opens_a_long_way_goes_before_a_longer_one(store: ArtefactStore) -> None:
    opener = Sum("opener", 1.0, seconds=1)
    tasks = [opener, Sum("long", 1.0, seconds=5), Sum("way", 1.0, after=(opener,), seconds=9)]
    diary = Diary()
    do(tasks, [], store, 1, diary)
    assert diary.starts == ["opener", "way", "long"]


def test_a_failure_stops_only_what_hangs_on_it(store: ArtefactStore) -> None:
    bad = Sum("bad", 1.0, fault="foreseen")
    after = Sum("after", 1.0, after=(bad,))
    last = Sum("last", 1.0, after=(after,))
    good = Sum("good", 1.0)
    outcomes = do([bad, after, last, good], [], store, 2)
    reason = "The wall is too thin. Take 2 mm."
    assert outcomes[bad.recipe.key].reason == reason
    assert outcomes[after.recipe.key].reason == outcomes[last.recipe.key].reason
    check_values(outcomes[after.recipe.key].reason, "bad", reason)
    assert outcomes[good.recipe.key].reason == ""


def test_an_unforeseen_error_keeps_its_traceback(store: ArtefactStore) -> None:
    bad = Sum("bad", 1.0, fault="unforeseen")
    outcome = do([bad], [], store, 1)[bad.recipe.key]
    assert outcome.reason == "KeyError: 'tilt'"
    assert "Traceback" in outcome.trace


def test_of_many_tasks_each_is_taken_once_and_the_longest_ways_first() -> None:
    openers = [Sum(f"opener {i}", 1.0, seconds=float(i)) for i in range(1000)]
    tasks: list[Task] = [*openers, *(Sum(f"end {i}", 1.0, after=(openers[i % 1000],)) for i in range(3000))]
    schedule = Schedule(tasks, [])
    taken = []
    while (task := schedule.next_task()) is not None:
        taken.append(task.name)
        assert [how.reason for _, how in schedule.complete(task, Outcome())] == [""]
    assert len(taken) == 4000
    assert taken[0] == "opener 999"
    assert taken[1:4] == ["opener 998", "opener 997", "opener 996"]


def test_a_task_that_nothing_can_open_is_ended_and_not_waited_for(store: ArtefactStore) -> None:
    last = Sum("last", 1.0, after=(Sum("never planned", 1.0),))
    outcomes = do([last], [], store, 1)
    assert outcomes[last.recipe.key].reason


def test_time_limit_is_generous_and_grows_with_the_cost() -> None:
    assert time_limit(Sum("short", 1.0, seconds=0.5)) == 3700.0
    assert time_limit(Sum("long", 1.0, seconds=100.0)) == 23600.0
