"""Mutated files at every door of the command line that reads one: read, or refused in a sentence with exit code 2.

``python tests/corpus/fuzz.py 5000`` tries 5 000 files over all doors, ``… 5000 7`` those of another seed, and
``… 500 7 layout.dxf`` those of one door.
"""

from __future__ import annotations

import contextlib
import faulthandler
import io
import os
import re
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from unittest import mock

import numpy as np
from fuzz_doors import DOORS, Read, house

from palpate.cli import border

LONGEST_S = 20
SLOW = {"profile.step": 10}
"""Fraction of the files of a door that takes seconds a file, a process of the CAD kernel each: one in so many."""
KEPT = os.environ.get("FUZZ_KEPT", "")
"""Folder to which files with a wrong outcome are copied."""
TOKENS = ("nan", "inf", "1e999", "-1e308", "-1", "0", "", "9" * 21, "ÿ", "\0", "<", "[", '"', "null", "{}", ";")


class HungError(BaseException):
    """A file is read for longer than `LONGEST_S`; no reader catches this."""


def mutate(content: bytes, random: np.random.Generator) -> bytes:
    """The content with bytes changed, doubled, removed or cut off, or a number replaced by a token."""
    data, at = bytearray(content), int(random.integers(max(len(content), 1)))
    kind, many = random.integers(7), int(random.integers(1, 40))
    token = str(random.choice(TOKENS)).encode()
    if kind == 0:
        for place in random.integers(0, max(len(data), 1), many):
            data[place : place + 1] = bytes([int(random.integers(256))])
    elif kind == 1:
        del data[at:]
    elif kind == 2:
        data[at:at] = data[at : at + many]
    elif kind == 3:
        del data[at : at + many]
    elif kind == 4:
        data[at : at + 1] = bytes(byte ^ 1 << int(random.integers(8)) for byte in data[at : at + 1])
    elif kind == 5:
        data[at:at] = token
    else:
        numbers = [match.span() for match in re.finditer(rb"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", content[at:][:2000])]
        first, last = numbers[int(random.integers(len(numbers)))] if numbers else (0, 0)
        data[at + first : at + last] = token
    return bytes(data)


def is_finite(value: object) -> bool:
    """Whether no number in a result is NaN or infinite."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind not in "fc" or bool(np.isfinite(value).all())
    if isinstance(value, dict | list | tuple):
        return all(map(is_finite, value.values() if isinstance(value, dict) else value))
    if is_dataclass(value) and type(value).__module__.startswith("palpate.camera"):
        return all(is_finite(getattr(value, field.name)) for field in fields(value))
    return not isinstance(value, float) or np.isfinite(value)


def outcome(read: Read, path: Path) -> tuple[int, str]:
    """Exit code of a door for a file, and what is wrong with it; empty if it is read, or refused as it must be."""
    shown, said, tracebacks = io.StringIO(), io.StringIO(), []
    logged = mock.patch.object(border, "_write_log", side_effect=lambda: tracebacks.append(traceback.format_exc()))
    signal.signal(signal.SIGALRM, _hang)
    signal.alarm(LONGEST_S)
    faulthandler.dump_traceback_later(3 * LONGEST_S, exit=True, file=sys.__stderr__)  # a library that hangs

    def call() -> None:
        if not is_finite(read(path)):
            raise ArithmeticError("a number of the result is not finite")

    try:
        with logged, contextlib.redirect_stdout(shown), contextlib.redirect_stderr(said), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            code = border.guarded(call)
    except HungError:
        return 1, "hangs\n" + traceback.format_exc()
    except SystemExit as left:
        code = left.code
    finally:
        signal.alarm(0)
        faulthandler.cancel_dump_traceback_later()
    message, wrong = said.getvalue(), ""
    if tracebacks or code not in (0, 1, 2):  # 1 is a unit outside its tolerances
        wrong = "".join(tracebacks) or f"exit code {code}: {message}"
    elif code == 2:
        good = re.search(r"^Error: .{20,} \[[a-z0-9_-]+\]$", message, re.M | re.S) and "Traceback" not in message
        wrong = "" if good else f"no sentence: {message}"
    elif re.search(r"\b(NaN|Infinity)\b", shown.getvalue()):
        wrong = f"nonsense: {shown.getvalue()}"
    return int(code or 0), wrong


def _hang(*_: object) -> None:
    raise HungError


def faults(name: str, count: int, folder: Path, seed: int = 0) -> Iterator[str]:
    """Wrong outcomes of mutations of one door's file, or of the files of its folder in turn."""
    house()  # drawn before the time of a file is taken
    write, read = DOORS[name]
    path, random = folder / name, np.random.default_rng([seed, *name.encode()])
    path.parent.mkdir(exist_ok=True)
    write(path)
    code, wrong = outcome(read, path)
    if code == 2 or wrong:
        yield f"{name} is not read as drawn: {wrong}"
    files = sorted(one for one in path.rglob("*") if one.is_file()) if path.is_dir() else [path]
    for number in range(count):
        chosen = files[int(random.integers(len(files)))]
        content = chosen.read_bytes()
        chosen.write_bytes(mutate(content, random))
        code, wrong = outcome(read, path)
        if wrong:
            if KEPT:
                shutil.copy(chosen, Path(KEPT) / f"{name}-{number}{chosen.suffix}")
            yield f"{name} {number} {chosen.name}: {wrong}"
        chosen.write_bytes(content)


def run(count: int, names: list[str], seed: int = 0) -> list[str]:
    """Wrong outcomes of so many files over these doors."""
    found: list[str] = []
    slow = sum(name in SLOW for name in names)
    each = -(-count // max(len(names) - slow, 1))
    for name in names:
        print(f"{time.process_time():5.0f} s {name}", file=sys.stderr)
        with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
            found += faults(name, max(each // SLOW.get(name, 1), 1), Path(place) / "door", seed)
    return found


if __name__ == "__main__":
    del __file__  # the processes of the CAD kernel need not import this file
    faulthandler.enable()
    chosen = sys.argv[3:] or list(DOORS)
    wrong = run(int(sys.argv[1]), chosen, int((*sys.argv, 0)[2]))
    print(f"{sys.argv[1]} files, {len(chosen)} doors, {len(wrong)} faults", *wrong, sep="\n")
