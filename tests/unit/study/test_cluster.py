"""The same tasks on a Dask cluster of processes on this machine."""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest
from small_task import Sum, read, starts

from errors import check_values, refused
from needs import needs
from palpate.core import ArtefactStore
from palpate.core.run import Progress
from palpate.study import check_cluster_address
from palpate.study.cluster import ClusterWorkers
from palpate.study.schedule import run_task, run_task_graph


@pytest.fixture
def store(tmp_path: Path) -> ArtefactStore:
    return ArtefactStore(tmp_path)


def tree(lasts: float) -> list[Sum]:
    """Eight tasks and their sum."""
    parts = [Sum(f"part {i}", float(i), lasts=lasts) for i in range(8)]
    return [*parts, Sum("whole", 100.0, after=tuple(parts))]


@pytest.mark.parametrize(
    "where", ["moon", "local:0", "local:9999", "local:-1", "tcp://", "http://a:1", "tcp://a;b:1"]
)
def test_check_place_refuses_what_is_no_cluster(where: str) -> None:
    with refused("cluster-malformed", "local:N"):
        check_cluster_address(where)


@pytest.mark.parametrize("where", ["local:1", "local:1024", "tcp://10.0.0.1:8786", "tls://head.example:8786"])
def test_check_place_lets_the_two_forms_pass(where: str) -> None:
    check_cluster_address(where)


def test_without_the_library_it_is_said_what_to_install(
    store: ArtefactStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with refused("extra-missing", ".[cluster]"):
        ClusterWorkers("local:1")


def test_a_killed_worker_costs_a_cluster_nothing_but_time(store: ArtefactStore, tmp_path: Path) -> None:
    needs("distributed")
    tasks = tree(lasts=0.5)
    bad = Sum("bad", 1.0, fault="unforeseen")
    with ClusterWorkers("local:2") as pool:
        assert pool.size == 2
        killer = threading.Thread(target=_kill_one, args=(pool, store))
        killer.start()
        outcomes = run_task_graph([*tasks, bad], [], pool, store)
        killer.join()
    assert [outcomes[task.recipe.key].reason for task in tasks] == [""] * 9
    assert outcomes[bad.recipe.key].reason == "KeyError: 'tilt'"
    assert starts(store, "whole") == 1
    other = ArtefactStore(tmp_path / "other")
    other.root.mkdir()
    for task in tasks:
        run_task(task, other, Progress())
    for task in tasks:
        assert read(store, task) == read(other, task)
        assert store.path(task.recipe).read_bytes() == other.path(task.recipe).read_bytes()


def _kill_one(pool: ClusterWorkers, store: ArtefactStore) -> None:
    """Kill a worker process while its second task is at work."""
    while not (store.root / "starts.log").exists() or len((store.root / "starts.log").read_text().splitlines()) < 3:
        time.sleep(0.05)
    pids = list(pool._client.run(os.getpid).values())
    assert len(pids) == 2
    os.kill(pids[0], signal.SIGKILL)


@pytest.mark.slow
def test_a_hung_task_is_stopped_on_a_cluster_too(store: ArtefactStore) -> None:
    needs("distributed")
    hung, good = Sum("hung", 1.0, fault="hung", seconds=9), Sum("good", 1.0)
    with ClusterWorkers("local:1") as pool:
        outcomes = run_task_graph([hung, good], [], pool, store, limit_s=20.0)
    check_values(outcomes[hung.recipe.key].reason, "20 s")
    assert "hang_here" in outcomes[hung.recipe.key].trace
    assert outcomes[good.recipe.key].reason == ""


def test_a_scheduler_that_does_not_answer_is_an_error_with_a_remedy(
    store: ArtefactStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs("distributed")
    monkeypatch.setattr("palpate.study.cluster.CONNECT_S", 1.0)
    with refused("scheduler-silent", "dask scheduler"):
        ClusterWorkers("tcp://127.0.0.1:9")
