"""The border where errors meet a person: one clear sentence and the remedy, never a traceback."""

from __future__ import annotations

import os
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cyclopts import CycloptsError
from pydantic import ValidationError

from palpate.core import PalpateError

DONE, FAULT, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""

_FLAGS = {"tilt_deg": "tilt", "azimuth_deg": "azimuth", "image_step": "step", "count": "markers", "name": "material"}
"""Flags whose name is not that of the spec's field."""


def guarded(command: Callable[[], Any]) -> int:
    """Run `command`; print what went wrong to standard error and return the exit code."""
    try:
        code = command()
    except PalpateError as error:
        return _refuse(error.what, error.remedy)
    except ValidationError as error:
        return _refuse("\n".join(_say(details) for details in error.errors()), "See --help for units and bounds.")
    except CycloptsError as error:
        return _refuse(str(error).strip(), "See --help.")
    except KeyboardInterrupt:
        print("Interrupted.", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has left
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAULT
    except Exception as error:
        print(f"palpate failed: {type(error).__name__}. Details: {_write_log()}", file=sys.stderr)
        return FAULT
    return code if isinstance(code, int) else DONE


def _refuse(what: str, remedy: str) -> int:
    print(f"Error: {what}" + (f"\n{remedy}" if remedy else ""), file=sys.stderr)
    return BAD_INPUT


def _say(details: Any) -> str:
    place = [str(part) for part in details["loc"]]
    flag = "--" + _FLAGS.get(place[0], place[0]).replace("_", "-") + ": " if place else ""
    given, message = details["input"], details["msg"].rstrip(".")
    shown = f" (given {given})" if isinstance(given, str | int | float) and str(given) not in message else ""
    return f"{flag}{message}{shown}."


def _write_log() -> Path:
    path = Path(tempfile.gettempdir()) / f"palpate-{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}.log"
    path.write_text(f"{' '.join(sys.argv)}\n\n{traceback.format_exc()}")
    return path
