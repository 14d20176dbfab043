"""An errand: long work in a process of its own, with progress, that can be called off."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from palpate.core import PalpateError, worker_process

Report = Callable[[float], None]
Work = Callable[..., Any]

_PATIENCE_S = 3.0


class Job:
    """Runs `work(*arguments, report)` in a fresh process; `report` takes the share done, from 0 to 1.

    Parameters
    ----------
    work
        A function of a module, found there by the new process.
    *arguments
        What it is given; it must survive pickling.

    Attributes
    ----------
    share
        How much is done, from 0 to 1.
    result
        What the work gave back, once `done`.
    fault
        Why there is no result; empty where there is one.
    cancelled
        Whether it was called off.
    """

    def __init__(self, work: Work, *arguments: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, there = context.Pipe(duplex=False)
        self._process = context.Process(target=_run, args=(work, arguments, there, os.getpid()), daemon=True)
        with worker_process.single_threaded():
            self._process.start()
        there.close()
        self.share = 0.0
        self.result: Any = None
        self.fault = ""
        self.cancelled = False
        self.done = False

    def poll(self) -> bool:
        """Take in what the process sent meanwhile; whether it is done."""
        while not self.done:
            try:
                if not self._pipe.poll():
                    break
                kind, content = self._pipe.recv()
            except (EOFError, OSError):
                if not self.done:  # else it was called off while we looked
                    self._process.join(_PATIENCE_S)
                    self._end(f"The worker died with code {self._process.exitcode}.")
                break
            if kind == "share":
                self.share = float(content)
            elif kind == "result":
                self.result = content
                self._end("")
            else:
                self._end(str(content))
        return self.done

    def cancel(self) -> None:
        """Stop the work and its process."""
        if not self.done:
            self._process.terminate()
            self.cancelled = True
            self._end("Cancelled.")

    def _end(self, fault: str) -> None:
        self.done, self.fault = True, fault
        self._process.join(_PATIENCE_S)
        if self._process.is_alive():
            self._process.kill()
        self._pipe.close()


def _run(work: Work, arguments: tuple[Any, ...], pipe: Connection, parent: int) -> None:
    worker_process.attach_to_parent(parent)
    try:
        result = work(*arguments, lambda share: pipe.send(("share", share)))
    except PalpateError as error:
        pipe.send(("fault", str(error)))
    except Exception as error:  # nobody else could say it
        pipe.send(("fault", f"The work failed: {type(error).__name__}: {error}"))
    else:
        pipe.send(("result", result))
