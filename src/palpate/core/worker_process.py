"""Processes that work for another one: one thread each, deaf to Ctrl-C, gone when their parent is gone."""

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
"""What numerical libraries read, when they are loaded, to know how many threads they may use."""
_CHANGING = threading.RLock()
"""Held while the environment is another one."""
_PARENT_CHECK_S = 1.0
"""How often a worker looks for its parent, s."""


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
    """Block Ctrl-C in this thread, which a new process inherits; the mask before, `None` on Windows."""
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
