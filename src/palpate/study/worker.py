"""The life of a worker process: one thread, deaf to Ctrl-C, gone when its parent is gone."""

from __future__ import annotations

import errno
import faulthandler
import os
import signal
import time
import traceback
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from palpate.core import ArtefactStore, PalpateError, StoreError, worker_process
from palpate.study.task import MissingArtefactError, Task

ASK_WHERE: signal.Signals | None = getattr(signal, "SIGUSR1", None)
"""Asks a worker where its program stands, before it is ended; not on every system."""

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
"""What the system says where nothing more can be written."""


class TaskStatus(StrEnum):
    """How a task ended."""

    MADE = "made"
    FOUND = "found"
    """Another run made the artefact in the meantime."""
    BUSY = "busy"
    """Another run makes the artefact now."""
    FAILED = "failed"
    MISSING = "input missing"
    """An artefact that the task reads is broken or gone."""
    UNWRITABLE = "store cannot be written"
    DIED = "worker died"


@dataclass(frozen=True)
class TaskOutcome:
    """How a task ended in its worker.

    Attributes
    ----------
    reason
        Empty, or one sentence why there is no artefact.
    trace
        Traceback of an error that nobody foresaw; empty otherwise.
    seconds
        Wall-clock time, s.
    ended
        How the task ended; the schedule goes by it.
    missing
        Key of the artefact that the task could not read; empty otherwise.
    """

    reason: str
    trace: str
    seconds: float
    ended: TaskStatus = TaskStatus.MADE
    missing: str = ""


def init_worker(parent: int, traces: Path | None = None) -> None:
    """Prepare a new worker whose parent has the process id `parent`.

    Where the interpreter breaks down, or is asked by the signal `ASK_WHERE`, it writes to the file `traces` where the
    program stood.
    """
    worker_process.attach_to_parent(parent)
    if traces is not None:
        try:
            file = traces.open("w")  # open as long as the process lives
        except FileNotFoundError:
            os._exit(1)  # its pool was shut down while it started
        faulthandler.enable(file)
        if ASK_WHERE is not None:
            faulthandler.register(ASK_WHERE, file)


def run_task(task: Task, store: ArtefactStore) -> TaskOutcome:
    """Do one task; whatever goes wrong is an outcome, never an exception.

    While a task is done, its lease is held; what another run has made in the meantime is not made again.
    """
    started = time.perf_counter()

    def outcome(ended: TaskStatus, reason: str = "", trace: str = "", missing: str = "") -> TaskOutcome:
        return TaskOutcome(reason, trace, time.perf_counter() - started, ended, missing)

    try:
        with store.lease(task.recipe) as free:
            if not free:
                return outcome(TaskStatus.BUSY)
            if store.has(task.recipe, task.suffix):
                return outcome(TaskStatus.FOUND)
            task.make(store)
    except MissingArtefactError as error:
        return outcome(TaskStatus.MISSING, str(error), missing=error.key)
    except StoreError as error:
        return outcome(TaskStatus.UNWRITABLE, str(error))
    except PalpateError as error:
        return outcome(TaskStatus.FAILED, str(error))
    except Exception as error:
        full = isinstance(error, OSError) and error.errno in FULL
        ended = TaskStatus.UNWRITABLE if full else TaskStatus.FAILED
        return outcome(ended, f"{type(error).__name__}: {error}", traceback.format_exc())
    return outcome(TaskStatus.MADE)
