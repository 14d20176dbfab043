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
        masked, deferred = _block_interrupts(), _DeferredInterrupt()
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
            deferred.deliver()


class _DeferredInterrupt:
    """Ctrl-C that another thread of this process receives, to be raised in the main thread later.

    A blocked signal goes to any thread that does not block it, and Python raises it in the main thread at once.
    """

    def __init__(self) -> None:
        self._is_main = threading.current_thread() is threading.main_thread()
        self._came = False
        self._before = signal.signal(signal.SIGINT, self._note) if self._is_main else None

    def _note(self, number: int, frame: object) -> None:
        self._came = True

    def deliver(self) -> None:
        """Restore the handler, and call it if Ctrl-C came."""
        if self._is_main:
            signal.signal(signal.SIGINT, signal.SIG_DFL if self._before is None else self._before)
            if self._came and callable(self._before):
                self._before(signal.SIGINT, None)


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
