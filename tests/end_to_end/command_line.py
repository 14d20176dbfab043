"""The command line as a process of its own, as a person starts it."""

import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]


def start(words: Sequence[str | Path]) -> "subprocess.Popen[str]":
    """Start the command line in a process group of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "palpate", *map(str, words)],
        cwd=ROOT / "src",
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=_listen_to_interrupts,
    )


def _listen_to_interrupts() -> None:
    """As in a terminal: what a shell starts in the background has them ignored, and hands that on."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def finish(words: Sequence[str | Path]) -> "subprocess.CompletedProcess[str]":
    """Run the command line to its end."""
    process = start(words)
    out, err = process.communicate(timeout=600)
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)
