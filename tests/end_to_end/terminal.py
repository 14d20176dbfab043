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
START, WIDTH, END = "\x01", "\x02", "\x03"
"""Marks in the output: before a command, around the width of what follows, and before the exit code."""
PROGRAM = f"""
import fcntl, json, struct, sys, termios
sys.path.insert(0, "{ROOT}/src")
from palpate.cli import main
from palpate.cli.output import JsonOutput, Output

def print_at(width):
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
    print(f"{WIDTH}{{width}}{WIDTH}", end="", flush=True)

def at_every_width(show):
    def show_at_every_width(output, *parts):
        for width in (*widths[1:], widths[0]):
            print_at(width)
            show(output, *parts)
    return show_at_every_width

for kind in (JsonOutput, Output):
    kind.show = at_every_width(kind.show)
commands, widths = json.load(sys.stdin)
for words in commands:
    print("{START}", end="", flush=True)
    print_at(widths[0])
    try:
        main(words)
    except SystemExit as left:
        print(f"{END}{{left.code}}", end="", flush=True)
"""
"""One process for many commands: the package is imported once. Each command computes once; its tables and sentences
are printed at every width, and what it prints while it runs at the first."""


@dataclass(frozen=True)
class Shown:
    """What a command showed in terminals.

    Attributes
    ----------
    text
        Width in columns → standard output.
    code
        Exit code.
    """

    text: dict[int, str]
    code: int

    @property
    def faults(self) -> dict[int, list[str]]:
        """Width → lines with a cut text, or longer than the terminal is wide without being one word."""
        found = {
            width: [one for one in text.split("\n") if CUT.search(one) or (len(one) > width and len(one.split()) > 1)]
            for width, text in self.text.items()
        }
        return {width: lines for width, lines in found.items() if lines}


def show(commands: Sequence[str], widths: Sequence[int], folder: Path, program: str = PROGRAM) -> list[Shown]:
    """Run commands one after the other in one folder, and show each in terminals of these widths."""
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
    process.stdin.write(json.dumps([[words.split() for words in commands], widths]).encode())
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
    return [_shown(part) for part in parts]


def _shown(part: str) -> Shown:
    printed, code = part.split(END)
    _, *pieces = printed.split(WIDTH)
    text: dict[int, str] = {}
    for width, piece in zip(pieces[::2], pieces[1::2], strict=True):
        text[int(width)] = text.get(int(width), "") + piece
    return Shown(text, int(code))
