"""Worker processes: one thread each, ignoring Ctrl-C, ended with their parent."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

_THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Variables by which numerical libraries limit their number of threads when they are loaded."""
_CHANGING = threading.RLock()
"""Lock of the environment while it is changed."""
_PARENT_CHECK_S = 1.0
"""Interval at which a worker checks its parent, s."""


@contextmanager
def single_threaded() -> Iterator[None]:
    """Let processes started inside use one thread and ignore Ctrl-C; threads of this process take turns."""
    with _CHANGING:
        before = {name: os.environ.get(name) for name in _THREAD_VARIABLES}
        os.environ.update(dict.fromkeys(_THREAD_VARIABLES, "1"))
        masked = _block_interrupts()
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value
            if masked is not None:  # last: a Ctrl-C that was blocked is raised here
                signal.pthread_sigmask(signal.SIG_SETMASK, masked)


def _block_interrupts() -> set[int] | None:
    """Block Ctrl-C in this thread and new processes; return the previous mask, `None` on Windows."""
    if not hasattr(signal, "pthread_sigmask"):
        return None
    resource_tracker.ensure_running()  # its start would unblock Ctrl-C again
    return set(signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}))


def attach_to_parent(parent: int) -> None:
    """Prepare this new process, which works for the one with the process id `parent`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_leave_with_parent, args=(parent,), daemon=True).start()


def _leave_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_PARENT_CHECK_S)
    os._exit(1)
