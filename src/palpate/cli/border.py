"""Conversion of errors into a sentence, a remedy and a code for the user, without a traceback."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable
from contextvars import ContextVar
from pathlib import Path
from types import FrameType
from typing import Any

from cyclopts import Argument, CycloptsError, default_name_transform
from pydantic import ValidationError

from palpate.core import PalpateError, Spec

DONE, FAULT, OUTSIDE, BAD_INPUT, INTERRUPTED = 0, 1, 1, 2, 130
"""Exit codes; `OUTSIDE` is that of a figure, a marker or a row outside its tolerance."""
_POSTPONE_S = 0.02
"""Time until an interruption is tried again, s; imports of a whole package last some tenths."""
_SWALLOWING = ("__del__", "_on_type_disposal")
"""Functions that Python calls while it frees an object; the second is a callback of numba's types."""
_RESULTS_FOLDER: ContextVar[Path | None] = ContextVar("folder of finished results", default=None)


def guarded(command: Callable[[], Any]) -> int:
    """Run `command`; print errors to standard error and return the exit code."""
    _RESULTS_FOLDER.set(None)
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:  # a job in the background, or a test
        return _answer(command)
    postponed: list[threading.Timer] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        """Interrupt; retry shortly after if the interruption would be lost."""
        if not _loses_interruption(frame):
            signal.default_int_handler(number, frame)
        postponed.append(threading.Timer(_POSTPONE_S, os.kill, (os.getpid(), signal.SIGINT)))
        postponed[-1].start()

    try:
        signal.signal(signal.SIGINT, interrupt)
    except ValueError:  # only the main thread is interrupted
        return _answer(command)
    try:
        return _answer(command)
    finally:
        for timer in postponed:
            timer.cancel()
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _loses_interruption(frame: FrameType | None) -> bool:
    """Return whether an import, a destructor or a weak reference's callback may swallow an interruption."""
    while frame is not None:
        code = frame.f_code
        if "importlib" in code.co_filename or code.co_filename.endswith("weakref.py") or code.co_name in _SWALLOWING:
            return True
        frame = frame.f_back
    return False


def _answer(command: Callable[[], Any]) -> int:
    try:
        code = command()
    except ValidationError as error:  # before `PalpateError`: a `SpecError` is both, and flags are named here
        return _refuse(_describe_all(error), "See --help for units and bounds.", _kind(error))
    except PalpateError as error:
        if _is_disk_full(error):
            return _report_full_disk(error.problem)
        return _refuse(error.problem, error.remedy, error.code)
    except CycloptsError as error:
        if isinstance(error.__cause__, ValidationError):
            said = _describe_all(error.__cause__, error.argument)
            return _refuse(said, "See --help for units and bounds.", _kind(error.__cause__))
        return _refuse(str(error).strip(), "See --help.", "usage")
    except KeyboardInterrupt:
        return _report_interruption()
    except BrokenPipeError:  # the reader of our output has left
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAULT
    except Exception as error:
        if _wraps_interruption(error):
            return _report_interruption()
        if _is_disk_full(error):
            return _report_full_disk(f"The results cannot be written: {error}.")
        print(f"palpate failed: {type(error).__name__}. Details: {_write_log()}", file=sys.stderr)
        return FAULT
    return code if isinstance(code, int) else DONE


def _report_interruption() -> int:
    folder = _RESULTS_FOLDER.get()
    kept = f"; {folder} keeps the finished results. Run the same command again to continue" if folder else ""
    print(f"\nInterrupted{kept}.", file=sys.stderr)
    return INTERRUPTED


def _wraps_interruption(error: BaseException | None) -> bool:
    """Return whether a compiled library, such as pydantic's, has turned an interruption into this error."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt) or "KeyboardInterrupt" in str(error):
            return True
        error = error.__cause__ or error.__context__
    return False


def keep_results(folder: Path) -> Path:
    """Return a folder of finished results, which the message of an interruption names."""
    _RESULTS_FOLDER.set(folder)
    return folder


def _is_disk_full(error: Exception) -> bool:
    from palpate.core.run import is_disk_full

    return getattr(error, "code", "") == "disk-unwritable" or is_disk_full(error)


def _report_full_disk(problem: str) -> int:
    """Report a full or read-only disk in one sentence with the folder of finished results."""
    folder = _RESULTS_FOLDER.get()
    saved = f"; {folder} keeps the finished results" if folder else ""
    resume = "free space or allow writing there, then run the same command again to continue"
    return _refuse(f"{problem.rstrip('.')}{saved}: {resume}.", "", "disk-unwritable")


def _refuse(what: str, remedy: str, code: str) -> int:
    print(f"Error: {what} [{code}]" + (f"\n{remedy}" if remedy else ""), file=sys.stderr)
    return BAD_INPUT


def _kind(error: ValidationError) -> str:
    """Return the code of a spec's first error, which is pydantic's type."""
    return error.errors()[0]["type"]


def _describe_all(error: ValidationError, argument: Argument | None = None) -> str:
    """Return the errors of a spec, one line per field, with flag names by the spec's argument."""
    transform = argument.parameter.name_transform if argument is not None else None
    return "\n".join(_describe(details, transform or default_name_transform) for details in error.errors())


def _describe(details: Any, transform: Callable[[str], str]) -> str:
    flag = f"--{transform(str(details['loc'][0]))}" if details["loc"] else ""
    return f"{Spec.describe_value(details, flag)}."


def _write_log() -> Path:
    path = Path(tempfile.gettempdir()) / f"palpate-{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}.log"
    path.write_text(f"{' '.join(sys.argv)}\n\n{traceback.format_exc()}")
    return path
