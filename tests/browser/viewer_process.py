"""The viewer as a process of its own, as a person starts it."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]


@contextmanager
def viewer(*words: str | Path, cwd: Path = ROOT / "src") -> Iterator[str]:
    """Run the viewer in a folder; yields its link."""
    process = subprocess.Popen(
        [sys.executable, "-m", "palpate", "view", *map(str, words), "--port", "0"],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), os.environ.get("PYTHONPATH", "")])},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert process.stdout is not None
    try:
        link = process.stdout.readline().removeprefix("Open ").strip()
        assert link.startswith("http://"), link + process.stdout.read()
        yield link
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
