"""What may go wrong while tasks are done, with real processes and real files."""

import itertools
import multiprocessing
import shutil
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from small_task import Sum, crew, do, end_crews, read, starts

from errors import check_values
from palpate.core import ArtefactStore, Recipe
from palpate.core.run import WORKER_DIED, LocalWorkers, Outcome, Progress
from palpate.study.schedule import Made, run_task, run_task_graph
from small_disk import mounted


@pytest.fixture(scope="module", autouse=True)
def crews() -> Iterator[None]:
    yield
    end_crews()


@pytest.fixture
def store(tmp_path: Path) -> ArtefactStore:
    return ArtefactStore(tmp_path)


def reasons(outcomes: dict[str, Outcome], *tasks: Sum) -> list[str]:
    return [outcomes[task.recipe.key].reason for task in tasks]


def test_a_task_that_kills_its_worker_twice_is_set_aside_and_the_rest_goes_on(store: ArtefactStore) -> None:
    bad = Sum("bad", 1.0, fault="killed", seconds=9)
    after = Sum("after", 1.0, after=(bad,))
    rest = [Sum(f"good {i}", 1.0, lasts=0.2) for i in range(3)]
    outcomes = do([bad, after, *rest], [], store, 2)
    (reason,) = reasons(outcomes, bad)
    assert reason.startswith(f"{WORKER_DIED} (SIGKILL)")
    assert starts(store, "bad") == 2
    check_values(*reasons(outcomes, after), "bad", reason)
    assert reasons(outcomes, *rest) == ["", "", ""]
    assert [starts(store, task.label) for task in rest] == [1, 1, 1], "a neighbour's death cost it its work"


def test_a_task_whose_worker_died_once_is_tried_again_and_succeeds(store: ArtefactStore) -> None:
    unlucky = Sum("unlucky", 2.0, fault="killed once", seconds=9)
    after = Sum("after", 1.0, after=(unlucky,))
    outcomes = do([unlucky, after], [], store, 2)
    assert reasons(outcomes, unlucky, after) == ["", ""]
    assert read(store, after) == 3.0
    assert starts(store, "unlucky") == 2


def test_a_hung_task_is_stopped_with_the_place_where_it_stood(store: ArtefactStore) -> None:
    hung = Sum("hung", 1.0, fault="hung", seconds=9)
    good = [Sum(f"good {i}", 1.0) for i in range(2)]
    do([Sum(f"first {i}", 1.0, lasts=1.0) for i in range(2)], [], store, 2)  # both workers are awake now
    started = time.monotonic()
    outcomes = do([hung, *good], [], store, 2, limit_s=4.0)
    assert time.monotonic() - started < 10
    late, *others = reasons(outcomes, hung, *good)
    check_values(late, "4 s")
    assert others == ["", ""]
    assert "hang_here" in outcomes[hung.recipe.key].trace


def test_a_clock_that_jumps_stops_nobody(store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "time", iter(range(10**9, 0, -(10**6))).__next__)
    task = Sum("task", 1.0, lasts=1.0)
    assert reasons(do([task], [], store, 1, limit_s=60.0), task) == [""]


@pytest.mark.parametrize("damage", ["truncated", "bit flipped", "emptied", "removed", "manifest lost"])
def test_an_input_that_breaks_in_the_middle_of_a_run_is_made_again(store: ArtefactStore, damage: str) -> None:
    one = Sum("one", 1.5)
    run_task(one, store, Progress())
    path = store.path(one.recipe)
    content = path.read_bytes()
    if damage == "truncated":
        path.write_bytes(content[:-1])
    elif damage == "bit flipped":
        path.write_bytes(bytes([content[0] ^ 1]) + content[1:])
    elif damage == "emptied":
        path.write_bytes(b"")
    elif damage == "removed":
        path.unlink()
    else:
        path.with_suffix(".manifest.json").unlink()
    last = [Sum("last", 10.0, after=(one,)), Sum("other", 20.0, after=(one,))]
    outcomes = do(last, [one.recipe.key], store, 2)
    assert reasons(outcomes, one, *last) == ["", "", ""]
    assert [read(store, task) for task in last] == [11.5, 21.5]
    assert starts(store, "one") == 2, "made again once, though two tasks missed it"
    broken = path.with_name(path.name + ".broken")
    assert broken.exists() == (damage != "removed")


def test_an_artefact_that_can_not_be_made_again_ends_what_needs_it(store: ArtefactStore) -> None:
    one = Sum("one", 1.5, fault="foreseen")
    last = Sum("last", 10.0, after=(one,))
    outcomes = do([last], [one.recipe.key], store, 1)
    check_values(*reasons(outcomes, last), "one", "The wall is too thin. Take 2 mm.")


def test_two_runs_at_once_make_nothing_twice(store: ArtefactStore) -> None:
    tasks = [Sum(f"task {i}", float(i), lasts=0.3) for i in range(6)]
    last = Sum("last", 100.0, after=tuple(tasks))
    with ThreadPoolExecutor(2) as runs, LocalWorkers(1) as other:
        pools = [crew(1), other]
        both = list(runs.map(lambda pool: run_task_graph([*tasks, last], [], pool, store), pools))
    assert [starts(store, task.label) for task in [*tasks, last]] == [1] * 7
    assert all(reasons(outcomes, *tasks, last) == [""] * 7 for outcomes in both)
    made = [how.value for outcomes in both for how in outcomes.values()]
    assert (made.count(Made.MADE), made.count(Made.FOUND)) == (7, 7)
    assert read(store, last) == 115.0
    assert not list(store.root.rglob("*.lock"))


def test_the_lease_of_a_killed_process_is_free_again(store: ArtefactStore) -> None:
    task = Sum("killed", 1.0, fault="killed", seconds=9)
    do([task], [], store, 1)
    assert list(store.root.rglob("*.lock")), "a killed process cannot clear its lock away"
    assert run_task(Sum("killed", 1.0), store, Progress()) is Made.MADE
    assert not list(store.root.rglob("*.lock"))


def test_an_artefact_of_an_older_version_is_left_alone_and_made_anew(store: ArtefactStore) -> None:
    old = Recipe("sum", ["one", 1.0], version="0")
    store.write(old, lambda path: path.write_text("wrong by today's knowledge") and None)
    one = Sum("one", 1.0)
    assert reasons(do([one], [], store, 1), one) == [""]
    assert read(store, one) == 1.0
    assert store.find(old) is not None


def test_an_artefact_under_the_key_of_another_is_never_read(store: ArtefactStore) -> None:
    one, two = Sum("one", 1.0), Sum("two", 2.0)
    run_task(two, store, Progress())
    for ending in (".h5", ".manifest.json"):
        target = store.path(one.recipe, ending)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(store.path(two.recipe, ending), target)
    last = Sum("last", 10.0, after=(one,))
    do([last], [one.recipe.key], store, 1)
    assert read(store, last) == 11.0
    reason = store.path(one.recipe).with_name(store.path(one.recipe).name + ".broken.reason").read_text()
    assert reason.strip()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with mounted(tmp_path / "disk", 256) as folder:
        yield folder


def test_a_full_disk_ends_the_run_with_the_reason_and_loses_nothing(small_disk: Path) -> None:
    store = ArtefactStore(small_disk)
    first = Sum("first", 1.0, seconds=9)
    run_task(first, store, Progress())
    ballast = small_disk / "ballast"
    _fill(ballast)
    rest = [Sum(f"task {i}", 1.0, after=(first,)) for i in range(4)]
    outcomes = do(rest, [first.recipe.key], store, 1)
    report = reasons(outcomes, *rest)
    assert "No space left on device" in report[0]
    assert all(report[1:])
    assert not list(small_disk.rglob(".writing-*"))
    ballast.unlink()
    assert read(store, first) == 1.0
    assert reasons(do(rest, [first.recipe.key], store, 1), *rest) == [""] * 4


def _fill(path: Path) -> None:
    with path.open("wb", buffering=0) as file, pytest.raises(OSError):  # noqa: PT011
        file.writelines(itertools.repeat(b"\0" * 4096))


def test_a_read_only_store_is_read_and_not_written(small_disk: Path) -> None:
    store = ArtefactStore(small_disk)
    one, two = Sum("one", 1.0), Sum("two", 2.0)
    run_task(one, store, Progress())
    broken = store.path(one.recipe)
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    assert store.find(one.recipe) == broken
    report = reasons(do([two], [], store, 1), two)[0]
    assert "Read-only file system" in report
    assert "--out" in report


def test_a_broken_artefact_in_a_read_only_store_is_not_read(small_disk: Path) -> None:
    store = ArtefactStore(small_disk)
    one = Sum("one", 1.0)
    run_task(one, store, Progress())
    store.path(one.recipe).write_text("9.0")
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    assert store.find(one.recipe) is None


def test_leaving_a_crew_ends_its_workers_at_once(store: ArtefactStore) -> None:
    started = time.monotonic()
    with LocalWorkers(1) as pool:
        pool.submit(run_task, Sum("hung", 1.0, fault="hung"), store)
        while not (store.root / "starts.log").exists():
            pool.wait(0.1)
            assert time.monotonic() - started < 60
        left = time.monotonic()
    assert time.monotonic() - left < 5


def test_a_worker_that_dies_while_it_has_nothing_to_do_is_replaced(store: ArtefactStore) -> None:
    with LocalWorkers(1) as pool:
        others = set(multiprocessing.active_children())
        run_task_graph([Sum("first", 1.0)], [], pool, store)
        (worker,) = set(multiprocessing.active_children()) - others
        worker.kill()
        worker.join()
        second = Sum("second", 2.0)
        assert reasons(run_task_graph([second], [], pool, store), second) == [""]


def test_a_resumed_run_does_only_what_is_missing(store: ArtefactStore) -> None:
    tasks = [Sum(f"task {i}", float(i)) for i in range(3)]
    for task in tasks[:2]:
        run_task(task, store, Progress())
    outcomes = do(tasks, [], store, 1)
    assert [outcomes[task.recipe.key].value for task in tasks] == [
        Made.FOUND,
        Made.FOUND,
        Made.MADE,
    ]
