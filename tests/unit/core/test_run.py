"""A pool of workers: values, errors, progress, limits and deaths of calls in real processes."""

import errno
import os
import time
from pathlib import Path
from typing import Any

import pytest

from palpate.core import PalpateError
from palpate.core.run import WORKER_DIED, Call, LocalWorkers, Outcome, Progress, Status


def count(number: int, progress: Progress) -> int:
    progress.plan(number)
    progress.begin("count", number)
    for done in range(1, number + 1):
        progress.advance("count", done, f"{done}")
    progress.note("counted")
    return number


def fail(kind: str, progress: Progress) -> Any:
    if kind == "unpicklable":
        return lambda: None
    if kind == "died":
        os._exit(3)
    if kind == "slow":
        time.sleep(600)
    raise {
        "full": OSError(errno.ENOSPC, "No space left on device"),
        "refused": PalpateError("It is too thin.", "Take 2 mm.", code="too-thin"),
        "unexpected": KeyError("tilt"),
    }[kind]


def outcome_of(pool: LocalWorkers, call: Call, seconds: float = 60.0) -> Outcome:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for ended, outcome in pool.wait(0.2):
            assert ended is call
            return outcome
    raise TimeoutError


class Kept(Progress):
    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []

    def advance(self, what: str, done: float, text: str = "") -> None:
        super().advance(what, done, text)
        self.texts.append(text)

    def note(self, text: str) -> None:
        self.texts.append(text)


def test_values_and_progress_come_back() -> None:
    progress = Kept()
    with LocalWorkers(1) as pool:
        outcome = outcome_of(pool, pool.submit(count, 3, progress=progress))
    assert (outcome.value, outcome.reason, outcome.status) == (3, "", Status.DONE)
    assert progress.texts == ["1", "2", "3", "counted"]
    assert progress.share == 1.0


def test_every_failure_is_an_outcome_and_the_worker_goes_on() -> None:
    with LocalWorkers(1) as pool:
        found = {}
        for kind in ("refused", "unexpected", "full", "unpicklable", "died"):
            found[kind] = outcome_of(pool, pool.submit(fail, kind))
        assert outcome_of(pool, pool.submit(count, 2)).value == 2
    assert {kind: how.status for kind, how in found.items()} == {
        "refused": Status.FAILED,
        "unexpected": Status.FAILED,
        "full": Status.UNWRITABLE,
        "unpicklable": Status.FAILED,
        "died": Status.DIED,
    }
    error = found["refused"].error
    assert error is not None
    assert (error.problem, error.remedy, error.code) == ("It is too thin.", "Take 2 mm.", "too-thin")
    assert found["unexpected"].reason == "KeyError: 'tilt'"
    assert "in fail" in found["unexpected"].trace
    assert found["died"].reason == f"{WORKER_DIED} (exit code 3)"


def test_work_that_cannot_be_pickled_is_a_failure() -> None:
    with LocalWorkers(1) as pool:
        assert outcome_of(pool, pool.submit(lambda progress: None)).status is Status.FAILED


def test_a_call_beyond_its_limit_is_stopped() -> None:
    with LocalWorkers(1) as pool:
        outcome_of(pool, pool.submit(count, 1))  # it is awake
        outcome = outcome_of(pool, pool.submit(fail, "slow", limit_s=1.5))
    assert outcome.status is Status.STOPPED
    assert "1.5 s" in outcome.reason
    assert "in fail" in outcome.trace


def test_a_worker_that_is_interrupted_at_its_start_ends_with_its_pool(monkeypatch: pytest.MonkeyPatch) -> None:
    class Starting:
        ended = False
        call = None

        def start(self, call: Call) -> None:
            raise KeyboardInterrupt

        def end(self) -> None:
            self.ended = True

    member = Starting()
    pool = LocalWorkers(1)
    monkeypatch.setattr(pool, "_members", [member])
    with pytest.raises(KeyboardInterrupt), pool:
        pool.submit(count, 1)
    assert member.ended


def test_the_folder_of_traces_goes_with_the_pool(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with LocalWorkers(2) as pool:
        pool.submit(fail, "slow")
        assert list(tmp_path.iterdir())
    assert not list(tmp_path.iterdir())
