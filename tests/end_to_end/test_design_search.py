"""A search with real presses: the same for one worker and two, killed in between, and its report from the command."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from palpate.optimise import optimise_design, propose, read_requirements
from palpate.study import read_study

pytest.importorskip("optuna")
pytest.importorskip("torch")
pytestmark = pytest.mark.slow

WANTED = """
name: small
depth: 3
least_depth: 1
max_tilt_deg: 9
heights: [18, 22]
base_radii: [20, 20]
thicknesses: [2, 3]
aspects: [1, 1]
markers: 37
known: 2
skins: 5
finalists: 0
"""
CUT = """
import sys
from pathlib import Path
from palpate.optimise import optimise_design, propose, read_requirements
if __name__ == "__main__":
    propose._COARSE_CELLS = 5
    optimise_design(read_requirements(sys.argv[1]), Path(sys.argv[2]), workers=1)
"""


@pytest.fixture
def wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(propose, "_COARSE_CELLS", 5)
    file = tmp_path / "wanted.yaml"
    file.write_text(WANTED)
    return file


def test_a_search_finds_the_same_however_it_was_done(wanted: Path, tmp_path: Path) -> None:
    spec, store = read_requirements(wanted), tmp_path / "cut" / "store"
    script = tmp_path / "cut.py"
    script.write_text(CUT)
    running = subprocess.Popen([sys.executable, str(script), str(wanted), str(tmp_path / "cut")])
    for _ in range(600):
        if len(list(store.glob("press/*/*.h5"))) >= 10:
            break
        time.sleep(0.5)
    running.send_signal(signal.SIGKILL)
    running.wait()
    made = {path: path.stat().st_mtime_ns for path in store.glob("press/*/*.h5")}
    assert len(made) >= 10
    again = optimise_design(spec, tmp_path / "cut", workers=2)
    whole = optimise_design(spec, tmp_path / "whole", workers=2)
    assert again == whole
    assert all(path.stat().st_mtime_ns == when for path, when in made.items()), "nothing is pressed twice"
    assert len(again.tried) == 5
    assert again.winner is not None
    assert again.winner.tried.meets
    assert 0 < again.winner.value("error") < 0.5


def test_the_command_reports_and_its_winner_can_be_run(wanted: Path, tmp_path: Path) -> None:
    from palpate.cli import main

    with pytest.raises(SystemExit) as left:
        main(["optimise", str(wanted), "--out", str(tmp_path / "out"), "--skins", "2", "--workers", "2"])
    assert left.value.code == 0
    found = json.loads((tmp_path / "out" / "front.json").read_text())
    assert found["skins"] == 2
    assert found["winner"]["markers"] <= 37
    (skin,) = read_study(tmp_path / "out" / "winner.yaml").designs.skins()
    assert skin.height == found["winner"]["height_mm"]
    (tmp_path / "other.yaml").write_text(WANTED + "dot: 1.2\n")
    with pytest.raises(SystemExit) as left:
        main(["optimise", str(tmp_path / "other.yaml"), "--out", str(tmp_path / "out")])
    assert left.value.code == 2
