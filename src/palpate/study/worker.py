"""The life of a worker process: one thread, deaf to Ctrl-C, gone when its parent is gone."""

from __future__ import annotations

import os
import signal
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from palpate.core import ArtefactStore, PalpateError
from palpate.study.task import Task

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""What numerical libraries read, when they are loaded, to know how many threads they may use."""

PARENT_CHECK_S = 1.0
"""How often a worker looks for its parent, s."""


@dataclass(frozen=True)
class Outcome:
    """How a task ended in its worker.

    Attributes
    ----------
    reason
        Empty, or one sentence why there is no artefact.
    trace
        Traceback of an error that nobody foresaw; empty otherwise.
    seconds
        Wall-clock time, s.
    """

    reason: str
    trace: str
    seconds: float


@contextmanager
def single_threaded() -> Iterator[None]:
    """Let processes started inside use one thread each."""
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def begin_worker(parent: int) -> None:
    """Prepare a new worker whose parent has the process id `parent`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, args=(parent,), daemon=True).start()


def perform(task: Task, store: ArtefactStore) -> Outcome:
    """Do one task; whatever goes wrong is an outcome, never an exception."""
    started = time.perf_counter()
    reason, trace = "", ""
    try:
        task.make(store)
    except PalpateError as error:
        reason = str(error)
    except Exception as error:
        reason, trace = f"{type(error).__name__}: {error}", traceback.format_exc()
    return Outcome(reason=reason, trace=trace, seconds=time.perf_counter() - started)


def _leave_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(PARENT_CHECK_S)
    os._exit(1)
