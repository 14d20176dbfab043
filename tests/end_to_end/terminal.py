"""The command line in a pseudo-terminal of a chosen width, as a person sees it."""

import json
import os
import pty
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
CUT = re.compile(r"(?<!\d)…|…(?!\d)")
"""Mark of a cut text; between two numbers it stands for a range."""
START, END = "\x01", "\x02"
PROGRAM = f"""
import fcntl, json, os, struct, sys, termios
sys.path.insert(0, "{ROOT}/src")
from palpate.cli import main
for words, width in json.load(sys.stdin):
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
    print("{START}", end="", flush=True)
    try:
        main(words)
    except SystemExit as left:
        print(f"{END}{{left.code}}", end="", flush=True)
"""
"""One process for many commands: the package is imported once."""


@dataclass(frozen=True)
class Shown:
    """What a command showed in a terminal.

    Attributes
    ----------
    width
        Columns of the terminal.
    text
        Standard output.
    code
        Exit code.
    """

    width: int
    text: str
    code: int

    @property
    def faults(self) -> list[str]:
        """Lines with a cut text, or longer than the terminal is wide without being one word."""
        lines = self.text.split("\n")
        return [one for one in lines if CUT.search(one) or (len(one) > self.width and len(one.split()) > 1)]


def show(commands: Sequence[tuple[str, int]], folder: Path, program: str = PROGRAM) -> list[Shown]:
    """Run commands one after the other in one folder, each in a terminal of its width."""
    reader, writer = pty.openpty()
    kept = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES", "FORCE_COLOR")}
    with (folder / "errors.txt").open("w") as errors:
        process = subprocess.Popen(
            [sys.executable, "-c", program],
            cwd=folder,
            env={**kept, "TERM": "dumb"},
            stdin=subprocess.PIPE,
            stdout=writer,
            stderr=errors,
        )
    os.close(writer)
    assert process.stdin is not None
    process.stdin.write(json.dumps([(words.split(), width) for words, width in commands]).encode())
    process.stdin.close()
    told = b""
    try:
        while part := os.read(reader, 65536):
            told += part
    except OSError:  # the terminal is closed when its last process has ended
        pass
    finally:
        os.close(reader)
        process.wait()
    parts = told.decode().replace("\r\n", "\n").split(START)[1:]
    assert len(parts) == len(commands), (folder / "errors.txt").read_text()[-2000:]
    return [Shown(width, *_ended(part)) for (_, width), part in zip(commands, parts, strict=True)]


def _ended(part: str) -> tuple[str, int]:
    text, code = part.split(END)
    return text, int(code)
