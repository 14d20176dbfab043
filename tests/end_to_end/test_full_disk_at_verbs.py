"""A disk that is full at every verb that writes: one sentence, exit code 2; with room it goes on."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from presses import TINY_STUDY
from small_disk import mounted

DATA = Path(__file__).parents[2] / "examples" / "data"
VERBS = {
    "run": ("run ../quick.yaml --out kept --workers 2", "kept"),
    "make": ("design make --markers 61 --out pack", ""),
    "press": ("press --cells 4 --depth 0.4 --export shown", ""),
    "learn": ("recording train {data}/recording --out kept", "kept"),
    "twin": ("calibration predict ../quick.yaml --out kept --workers 2", "kept"),
    "limit": ("design bound ../quick.yaml --out kept --workers 2", "kept"),
    "benchmark make": ("benchmark make --spec tiny --out kept --workers 2", "kept"),
    "optimise": ("search ../wanted.yaml --out kept --workers 2", "kept"),
}
"""Verb → its words, and the folder that keeps finished results."""
FAST = ("run", "press")
QUICK = """
name: quick
designs: {heights: [20 mm], thicknesses: [2 mm], markers: [7]}
mesh: {cells: 4}
tilts_deg: [0, 3]
obstacle: {depth: 3 mm, depth_step: 1 mm}
"""
"""A study whose first press fills the disk as soon as another's."""
WANTED = """
name: wanted
depth: 1
min_depth: 0.5
max_tilt_deg: 3
skins: 1
finalists: 0
"""


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with mounted(tmp_path / "disk", 128) as folder:
        yield folder


def palpate(words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "palpate", *words.format(data=DATA).split()]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=900)


@pytest.mark.parametrize(
    "verb", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in VERBS]
)
def test_a_full_disk_is_one_sentence_at_every_verb(verb: str, small_disk: Path) -> None:
    words, folder = VERBS[verb]
    (small_disk.parent / "quick.yaml").write_text(QUICK)
    (small_disk.parent / "wanted.yaml").write_text(WANTED)
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
    words, folder = "run ../tiny.yaml --out kept --workers 2", "kept"
    (small_disk.parent / "tiny.yaml").write_text(TINY_STUDY)
    subprocess.run(["mount", "-o", "remount,size=1m", str(small_disk)], check=True)  # some presses fit
    assert palpate(words, small_disk).returncode == 2
    made = {path: path.stat().st_mtime_ns for path in (small_disk / folder / "store").rglob("*.h5")}
    subprocess.run(["mount", "-o", "remount,size=256m", str(small_disk)], check=True)
    ended = palpate(words, small_disk)
    assert ended.returncode in (0, 1), ended.stderr
    assert {path: path.stat().st_mtime_ns for path in made} == made
    assert made
