"""A disk that is full at every verb that writes: one sentence, exit code 2; with room it goes on."""

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

DATA = Path(__file__).parents[2] / "examples" / "data"
VERBS = {
    "run": ("run {data}/small.yaml --out kept --workers 2", "kept"),
    "make": ("make --markers 61 --out pack", ""),
    "press": ("press --cells 4 --depth 0.4 --export shown", ""),
    "learn": ("learn {recording} --out kept", "kept"),
    "twin": ("twin {data}/small.yaml --out kept --workers 2", "kept"),
    "limit": ("limit {data}/small.yaml --out kept --workers 2", "kept"),
    "benchmark make": ("benchmark make --spec tiny --out kept --workers 2", "kept"),
    "optimise": ("optimise paper_task --out kept --workers 2", "kept"),
}
"""Verb → its words, and the folder that keeps finished results."""
FAST = ("run", "press")


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 128 KiB, where this user may mount one."""
    folder = tmp_path / "disk"
    folder.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", "size=128k", "none", str(folder)]
    if sys.platform != "linux" or subprocess.run(words, capture_output=True).returncode != 0:
        pytest.skip("only the administrator of a Linux system can mount a small disk")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def palpate(words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    recording = folder.parent / "recording"
    if "{recording}" in words:
        shutil.copytree(DATA / "recording", recording)
        rows = (recording / "poses.csv").read_text().splitlines()
        (recording / "poses.csv").write_text("\n".join(row for row in rows if ",rest," not in row))
    command = [sys.executable, "-m", "palpate", *words.format(data=DATA, recording=recording).split()]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=900)


@pytest.mark.parametrize(
    "verb", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in VERBS]
)
def test_a_full_disk_is_one_sentence_at_every_verb(verb: str, small_disk: Path) -> None:
    words, folder = VERBS[verb]
    if verb != "run":
        with (small_disk / "ballast").open("wb") as file:
            file.write(bytes(112 * 1024))
    ended = palpate(words, small_disk)
    assert ended.returncode == 2, ended.stderr
    assert "Traceback" not in ended.stderr
    said = [line for line in ended.stderr.splitlines() if line.endswith("[disk-unwritable]")]
    assert said == ended.stderr.splitlines()[-1:]
    assert "run the same command again to continue" in said[0]
    assert folder in said[0]


@pytest.mark.slow
def test_with_room_a_study_goes_on_and_makes_nothing_twice(small_disk: Path) -> None:
    words, folder = VERBS["run"]
    assert palpate(words, small_disk).returncode == 2
    made = {path: path.stat().st_mtime_ns for path in (small_disk / folder / "store").rglob("*.h5")}
    subprocess.run(["mount", "-o", "remount,size=256m", str(small_disk)], check=True)
    ended = palpate(words, small_disk)
    assert ended.returncode in (0, 1), ended.stderr
    assert {path: path.stat().st_mtime_ns for path in made} == made
    assert made
