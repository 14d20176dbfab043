"""Work in other processes: a pool of workers, the outcome of each call, and its progress."""

from __future__ import annotations

import faulthandler
import math
import multiprocessing
import os
import shutil
import signal
import tempfile
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Self

from palpate.core import worker_process
from palpate.core.errors import PalpateError
from palpate.core.files import is_disk_full
from palpate.core.progress import Progress
from palpate.core.store import StoreError

__all__ = [
    "WORKER_DIED",
    "Call",
    "LocalWorkers",
    "Outcome",
    "Progress",
    "Status",
    "WorkerPool",
    "is_disk_full",
    "run_call",
]

WORKER_DIED = "its worker process died, perhaps for want of memory"

_ASK_TRACE: signal.Signals | None = getattr(signal, "SIGUSR1", None)
"""Signal on which a worker writes where its program stands; not on every system."""
MOST_WORKERS = 1024
"""Maximum number of workers: a larger one is a typing error."""
_ANSWER_S = 0.5
"""Time that a worker has to write where its program stands, before it is killed, s. By hand."""
_DEATH_S = 5.0
"""Time that the system may take to end a process, s. By hand."""


class Status(StrEnum):
    """Outcome of a call."""

    DONE = "done"
    FAILED = "failed"
    UNWRITABLE = "results cannot be written"
    """The disk is full or read-only."""
    DIED = "worker died"
    STOPPED = "stopped at its time limit"


@dataclass(frozen=True)
class Outcome:
    """Result of a call in a worker.

    Attributes
    ----------
    value, reason
        Returned by the work, `None` after a failure; empty, or one sentence on the failure.
    trace
        Traceback of an unexpected error, or of the place where a worker was stopped.
    seconds
        Wall-clock time, s.
    status
        Kind of outcome.
    error
        Error that the user can correct, if the work raised one.
    """

    value: Any = None
    reason: str = ""
    trace: str = ""
    seconds: float = 0.0
    status: Status = Status.DONE
    error: PalpateError | None = None


@dataclass(frozen=True, eq=False)
class Call:
    """Work given to a pool.

    Attributes
    ----------
    work, arguments
        A function of a module, called with the arguments and a `Progress`; all are pickled.
    limit_s
        Time after which its worker is stopped, s.
    progress
        Receives the progress of the work.
    started
        Monotonic time at which it was given to a worker, s.
    """

    work: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit_s: float = math.inf
    progress: Progress = field(default_factory=Progress)
    started: float = field(default_factory=time.monotonic)


def run_call(work: Callable[..., Any], arguments: tuple[Any, ...], progress: Progress) -> Outcome:
    """Return the outcome of `work(*arguments, progress)` in this process; every error is an outcome."""
    started = time.perf_counter()
    try:
        value = work(*arguments, progress)
    except Exception as error:
        known = error if isinstance(error, PalpateError) else None
        status = Status.UNWRITABLE if isinstance(error, StoreError) or is_disk_full(error) else Status.FAILED
        reason = str(error) if known else f"{type(error).__name__}: {error}"
        trace = "" if known else traceback.format_exc()
        return Outcome(None, reason, trace, time.perf_counter() - started, status, known)
    return Outcome(value, seconds=time.perf_counter() - started)


class WorkerPool(ABC):
    """Workers, each with one call at a time; the end of its `with` block ends all of them at once."""

    def __init__(self) -> None:
        self._calls: dict[Call, bool] = {}
        """Calls at work → whether they were stopped at their limit."""
        self._early: list[tuple[Call, Outcome]] = []
        """Outcomes that are known without a worker."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of calls that can be at work at the same time."""

    @abstractmethod
    def shutdown(self) -> None:
        """End every worker, busy or idle."""

    @abstractmethod
    def _start(self, call: Call) -> None:
        """Give a call to an idle worker."""

    @abstractmethod
    def _collect(self, seconds: float) -> list[tuple[Call, Outcome]]:
        """Calls that have ended, after `seconds` at most."""

    @abstractmethod
    def _stop(self, call: Call) -> None:
        """End the worker of a call, whose outcome is then that it died."""

    def submit(
        self,
        work: Callable[..., Any],
        *arguments: Any,
        limit_s: float = math.inf,
        progress: Progress | None = None,
    ) -> Call:
        """Give work to an idle worker; at most `size` calls are given and not yet returned by `wait`."""
        call = Call(work, arguments, limit_s, progress or Progress())
        self._calls[call] = False
        try:
            self._start(call)
        except OSError:  # the system starts no more processes
            raise
        except Exception as error:  # the work cannot be pickled
            reason = f"{type(error).__name__}: {error}"
            self._early.append((call, Outcome(reason=reason, status=Status.FAILED)))
        return call

    def wait(self, seconds: float = 0.5) -> list[tuple[Call, Outcome]]:
        """Calls that have ended, after `seconds` at most; a worker that died or was stopped is replaced."""
        ended, self._early = self._early, []
        ended += self._collect(0.0 if ended else seconds)
        for index, (call, outcome) in enumerate(ended):
            if self._calls.pop(call) and outcome.status is Status.DIED:
                reason = f"it took longer than {call.limit_s:g} s and was stopped"
                ended[index] = call, Outcome(None, reason, outcome.trace, call.limit_s, Status.STOPPED)
        for call, stopped in self._calls.items():
            if not stopped and time.monotonic() > call.started + call.limit_s:
                self._calls[call] = True
                self._stop(call)
        return ended

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.shutdown()


class LocalWorkers(WorkerPool):
    """Processes on this machine, each with one thread; the death of one stops no more than its call.

    A process starts with its first call.
    """

    def __init__(self, workers: int) -> None:
        super().__init__()
        self._folder = Path(tempfile.mkdtemp(prefix="palpate-"))
        self._members = [_Worker(self._folder / f"{number}") for number in range(workers)]

    @property
    def size(self) -> int:
        return len(self._members)

    def shutdown(self) -> None:
        for member in self._members:
            member.end()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _start(self, call: Call) -> None:
        next(member for member in self._members if member.call is None).start(call)

    def _collect(self, seconds: float) -> list[tuple[Call, Outcome]]:
        busy = {each.pipe: each for each in self._members if each.pipe is not None and each.call is not None}
        if not busy:
            time.sleep(seconds)
        ended = []
        for pipe in wait(list(busy), seconds) if busy else []:
            member = busy[pipe]  # type: ignore[index]
            call, outcome = member.call, member.receive()
            if call is not None and outcome is not None:
                ended.append((call, outcome))
        return ended

    def _stop(self, call: Call) -> None:
        next(member for member in self._members if member.call is call).kill()


class _Worker:
    """One process, started with its first call and again after its death.

    `call` is the call at work, `None` if it is idle; `pipe` is this end of the connection to the process.
    """

    def __init__(self, traces: Path) -> None:
        self.call: Call | None = None
        self.pipe: Connection | None = None
        self._traces = traces
        self._process: BaseProcess | None = None

    def start(self, call: Call) -> None:
        """Give a call to the process; one that died while it was idle is replaced."""
        message = call.work, call.arguments
        if self.pipe is not None:
            with suppress(OSError):
                self.pipe.send(message)
                self.call = call
                return
            self.end()
        context = multiprocessing.get_context("spawn")
        with worker_process.single_threaded():  # a Ctrl-C in this block is raised at its end
            self.pipe, other = context.Pipe()
            arguments = (other, os.getpid(), self._traces)
            self._process = context.Process(target=_serve, args=arguments, daemon=True)
            self._process.start()
            other.close()
        with suppress(OSError):  # a process that died at its start is found by `receive`
            self.pipe.send(message)
        self.call = call

    def receive(self) -> Outcome | None:
        """Pass on the progress of the call; its outcome if it has ended."""
        while self.call is not None and self.pipe is not None:
            try:
                if not self.pipe.poll():
                    return None
                message = self.pipe.recv()
            except (EOFError, OSError):
                message = Outcome(None, f"{WORKER_DIED}{self._how()}", self._trace(), status=Status.DIED)
                self.end()
            except Exception as error:  # the value cannot be unpickled
                message = Outcome(reason=f"{type(error).__name__}: {error}", status=Status.FAILED)
            if isinstance(message, Outcome):
                self.call = None
                return message
            event, arguments = message
            getattr(self.call.progress, event)(*arguments)
        return None

    def kill(self) -> None:
        """End the process, after it has written where its program stands."""
        if self._process is None or self._process.pid is None:
            return
        if _ASK_TRACE is not None and self._traces.exists():  # before, the signal would end it without an answer
            with suppress(ProcessLookupError):
                os.kill(self._process.pid, _ASK_TRACE)
            limit, trace = time.monotonic() + _ANSWER_S, ""
            while not (trace and trace == self._trace()) and time.monotonic() < limit:  # it is written in pieces
                trace = self._trace()
                time.sleep(0.05)
        self._process.kill()

    def end(self) -> None:
        """End the process, busy or idle."""
        if self._process is not None and self._process.pid is not None:
            self._process.kill()
            self._process.join()
        if self.pipe is not None:
            self.pipe.close()
        self.pipe = self._process = None
        self._traces.unlink(missing_ok=True)

    def _how(self) -> str:
        """Signal or exit code with which the process ended, in brackets; empty if it is unknown."""
        if self._process is None:
            return ""
        self._process.join(_DEATH_S)
        code = self._process.exitcode
        if not code:
            return ""
        return f" ({signal.Signals(-code).name})" if -code in set(signal.Signals) else f" (exit code {code})"

    def _trace(self) -> str:
        """Text that the process has written on where its program stands."""
        with suppress(OSError):
            return self._traces.read_text(errors="replace")
        return ""


class _SentProgress(Progress):
    """Progress that a worker sends to the process that started it."""

    def __init__(self, pipe: Connection) -> None:
        super().__init__()
        self._pipe = pipe

    def plan(self, cost: float, text: str = "") -> None:
        self._pipe.send(("plan", (cost, text)))

    def begin(self, what: str, cost: float = 1.0, done: float = 0.0) -> None:
        self._pipe.send(("begin", (what, cost, done)))

    def advance(self, what: str, done: float, text: str = "") -> None:
        self._pipe.send(("advance", (what, done, text)))

    def finish(self, what: str, reason: str = "") -> None:
        self._pipe.send(("finish", (what, reason)))

    def note(self, text: str) -> None:
        self._pipe.send(("note", (text,)))


def _serve(pipe: Connection, parent: int, traces: Path) -> None:
    """Do the calls of the process `parent`, one at a time, until it closes the pipe.

    If the interpreter breaks down, or on the signal `_ASK_TRACE`, the place where the program stands is written to
    the file `traces`.
    """
    worker_process.attach_to_parent(parent)
    with suppress(OSError), traces.open("w") as file:  # the folder is missing if the pool ended in the meantime
        faulthandler.enable(file)
        if _ASK_TRACE is not None:
            faulthandler.register(_ASK_TRACE, file)
        while True:
            try:
                work, arguments = pipe.recv()
            except EOFError:
                return
            except Exception as error:  # the work cannot be unpickled here
                outcome = Outcome(
                    None, f"{type(error).__name__}: {error}", traceback.format_exc(), 0.0, Status.FAILED
                )
            else:
                outcome = run_call(work, arguments, _SentProgress(pipe))
            try:
                pipe.send(outcome)
            except OSError:
                return
            except Exception as error:  # the value cannot be pickled
                pipe.send(Outcome(reason=f"{type(error).__name__}: {error}", status=Status.FAILED))
