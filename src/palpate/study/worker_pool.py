"""Who does the tasks: a crew of worker processes, each with one task at a time."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import tempfile
import threading
import time
from abc import ABC, abstractmethod
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Self

from palpate.core import ArtefactStore, worker_process
from palpate.study.task import Task
from palpate.study.worker import ASK_WHERE, TaskOutcome, TaskStatus, init_worker, run_task

WORKER_DIED = "its worker process died, perhaps for want of memory"

ANSWER_S = 0.5
"""How long a worker that is to be ended has to say where it stands, s."""


_STARTING = threading.Lock()
"""Held while a process is started, so that two crews in one program do not take each other's for their own."""


class WorkerPool(ABC):
    """Does tasks, one a member, and tells how they ended; leaving its block ends all members at once."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of tasks that can be at work together."""

    @abstractmethod
    def submit(self, task: Task) -> None:
        """Give a task to a free member; at most `size` are given and not yet returned."""

    @abstractmethod
    def wait(self, seconds: float) -> list[tuple[Task, TaskOutcome]]:
        """Tasks that have ended, after `seconds` at most; a member that died is replaced."""

    @abstractmethod
    def cancel(self, task: Task) -> None:
        """End the member that does a task; `wait` then tells that it died, and where it stood if it could say."""

    @abstractmethod
    def shutdown(self) -> None:
        """End every member, at work or not."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.shutdown()


class LocalWorkers(WorkerPool):
    """Processes on this machine, each with one thread and an executor of its own: one that dies takes nobody along.

    Parameters
    ----------
    store
        Where artefacts are read and written.
    workers
        Number of processes.
    """

    def __init__(self, store: ArtefactStore, workers: int) -> None:
        self._store = store
        self._folder = Path(tempfile.mkdtemp(prefix="palpate-"))
        self._free = [_Member(self._folder / f"{number}") for number in range(workers)]
        self._size = workers
        self._busy: dict[Future[TaskOutcome], tuple[_Member, Task]] = {}

    @property
    def size(self) -> int:
        return self._size

    def submit(self, task: Task) -> None:
        member = self._free[-1]
        future = member.submit(task, self._store)  # a Ctrl-C while it starts leaves it to `shutdown`
        self._free.pop()
        self._busy[future] = (member, task)

    def wait(self, seconds: float) -> list[tuple[Task, TaskOutcome]]:
        if not self._busy:
            time.sleep(seconds)
        ended = []
        for future in wait(self._busy, timeout=seconds, return_when=FIRST_COMPLETED).done:
            member, task = self._busy.pop(future)
            try:
                outcome = future.result()
            except BrokenProcessPool:
                outcome = TaskOutcome(f"{WORKER_DIED}{member.how()}", member.trace(), 0.0, TaskStatus.DIED)
                member.leave()
            except Exception as error:  # what came back could not be read
                outcome = TaskOutcome(f"{type(error).__name__}: {error}", "", 0.0, TaskStatus.FAILED)
            self._free.append(member)
            ended.append((task, outcome))
        return ended

    def cancel(self, task: Task) -> None:
        for member, busy in self._busy.values():
            if busy is task:
                member.kill()

    def shutdown(self) -> None:
        for member, _ in self._busy.values():
            member.leave()
        for member in self._free:
            member.leave()
        shutil.rmtree(self._folder, ignore_errors=True)


class _Member:
    """One worker process, started with its first task and again after its death."""

    def __init__(self, traces: Path) -> None:
        self._traces = traces
        self._executor: ProcessPoolExecutor | None = None
        self._process: BaseProcess | None = None

    def submit(self, task: Task, store: ArtefactStore) -> Future[TaskOutcome]:
        """Let the process do a task; one that has died is replaced first."""
        if self._executor is not None:
            with suppress(BrokenProcessPool):  # it may have died while it had nothing to do
                return self._executor.submit(run_task, task, store)
            self.leave()
        with _STARTING, worker_process.single_threaded():
            self._executor = ProcessPoolExecutor(
                1,
                mp_context=multiprocessing.get_context("spawn"),
                initializer=init_worker,
                initargs=(os.getpid(), self._traces),
            )
            before = set(multiprocessing.active_children())
            future = self._executor.submit(run_task, task, store)
            self._process = next(iter(set(multiprocessing.active_children()) - before), None)
        return future

    def kill(self) -> None:
        """Ask the process where it stands, then end it."""
        if self._process is None or self._process.pid is None:
            return
        if ASK_WHERE is not None and self._traces.exists():  # else it could not answer yet, and would die of asking
            with suppress(ProcessLookupError):
                os.kill(self._process.pid, ASK_WHERE)
            limit, trace = time.monotonic() + ANSWER_S, ""
            while not (trace and trace == self.trace()) and time.monotonic() < limit:  # it is written in pieces
                trace = self.trace()
                time.sleep(0.05)
        self._process.kill()

    def how(self) -> str:
        """By which signal the process ended, in brackets; empty where it is not known."""
        if self._process is None:
            return ""
        end = time.monotonic() + 10 * ANSWER_S
        # the pool may be asking the system for the same exit code, and only one of the two is answered at once
        while (code := self._process.exitcode) is None and time.monotonic() < end:
            time.sleep(0.01)
        if code is None or code == 0:
            return ""
        return f" ({signal.Signals(-code).name})" if -code in set(signal.Signals) else f" (exit code {code})"

    def trace(self) -> str:
        """What the process has reported about where it stands."""
        with suppress(OSError):
            return self._traces.read_text(errors="replace")
        return ""

    def leave(self) -> None:
        """End the process, at work or not."""
        if self._process is not None and self._process.is_alive():
            self._process.kill()
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)
        self._executor = self._process = None
        self._traces.unlink(missing_ok=True)
