"""Ctrl-C at every verb that computes: one sentence, exit code 130, no traceback of any process."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

DATA = Path(__file__).parents[2] / "examples" / "data"
VERBS = {
    "press": ("press --whole --cells 30 --depth 12", ""),
    "learn": (f"recording train {DATA}/recording --out kept --targets rx_deg", "kept"),
    "run": (f"run {DATA}/small.yaml --out kept --workers 2", "kept"),
    "twin": (f"calibration predict {DATA}/small.yaml --out kept --workers 2", "kept"),
    "limit": (f"design bound {DATA}/small.yaml --out kept --workers 2", "kept"),
    "benchmark make": ("benchmark make --spec tiny --out kept --workers 2", "kept"),
    "bench": ("simulation bench --out kept --units 2 --markers 61", "results"),
    "optimise": ("search paper_task --out kept --workers 2", "kept"),
    "make": ("design make --markers 61 --out pack", ""),
    "verify": ("verify", ""),
    "convergence": ("design convergence --meshes 20 30", ""),
}
"""Verb → its words, and the folder that keeps finished results."""
FAST = ("press", "run")


@pytest.mark.parametrize(
    "verb", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in VERBS]
)
@pytest.mark.parametrize("seconds", [0.0, pytest.param(4.0, marks=pytest.mark.slow)])
def test_an_interrupted_command_says_one_sentence(verb: str, seconds: float, tmp_path: Path) -> None:
    words, folder = VERBS[verb]
    process = subprocess.Popen(
        [sys.executable, "-m", "palpate", *words.split()],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a job in the background ignores it
    )
    time.sleep(2.0)
    while folder and not (tmp_path / folder).exists() and process.poll() is None:
        time.sleep(0.1)  # before there is a folder nothing can be kept
    time.sleep(min(seconds, 1.0) if verb == "learn" else seconds)  # it takes some four seconds
    if process.poll() is not None:
        assert process.returncode == 0, process.communicate()[1]
        pytest.skip("it ended before the interruption")
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to all processes of the command
    _, error = process.communicate(timeout=60)
    assert process.returncode == 130, error
    assert "Traceback" not in error
    said = [line for line in error.splitlines() if line.startswith("Interrupted")]
    assert len(said) == 1
    assert error.splitlines()[-1] == said[0]
    assert folder in said[0]
