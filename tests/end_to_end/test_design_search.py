"""A search with real presses: the same for one worker and two, killed in between, and its report from the command."""

import importlib
import json
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import palpate.optimise.evaluate_skin as evaluation
import palpate.optimise.validate_designs as validation
from errors import check_values
from palpate.core import ArtefactStore
from palpate.design import Design, DomeSpec, MarkerSpec
from palpate.material import get_material
from palpate.mesh import MeshSpec
from palpate.optimise import RequirementsSpec, optimise_design, read_requirements, validate_front, write_front
from palpate.optimise.design_study import design_study
from palpate.simulation import VirtualBench, VirtualBenchSpec, run_bench
from palpate.simulation.result import pool_units
from palpate.study import Study, find_artefact, read_study
from presses import stored_folder

pytest.importorskip("optuna")
pytest.importorskip("torch")
pytestmark = pytest.mark.slow

WANTED = """
name: small
depth: 3
min_depth: 1
max_tilt_deg: 9
heights: [18, 22]
base_radii: [20, 20]
thicknesses: [2, 3]
aspects: [1, 1]
markers: 37
calibration_presses: 2
skins: 3
finalists: 0
"""
CUT = """
import sys
from pathlib import Path
from palpate.optimise import optimise_design, read_requirements
from palpate.optimise import evaluate_skin as evaluation
if __name__ == "__main__":
    evaluation._COARSE_CELLS, evaluation._COARSE_CONTACTS = 5, ("no-slip",)
    optimise_design(read_requirements(sys.argv[1]), Path(sys.argv[2]), workers=1)
"""


@pytest.fixture
def wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(evaluation, "_COARSE_CELLS", 5)
    file = tmp_path / "wanted.yaml"
    file.write_text(WANTED)
    return file


@pytest.fixture
def one_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quarter of the presses, where errors are not compared with those of units."""
    monkeypatch.setattr(evaluation, "_COARSE_CONTACTS", ("no-slip",))


@pytest.fixture
def searched(wanted: Path, one_contact: None) -> Path:
    """Folder of a search of `WANTED` from nothing, done once for all tests; only to be read."""
    spec = read_requirements(wanted)
    return stored_folder("search", [spec.model_dump_json(), 5], lambda made: optimise_design(spec, made, workers=2))


def coarse_study(spec: RequirementsSpec, *design: Any) -> Study:
    """The study that trains a design, on the mesh of the bench and with fewer poses."""
    study = design_study(spec, *design)
    coarse = {"mesh": MeshSpec(cells=5), "dataset": study.dataset.model_copy(update={"n_presses": 200})}
    return study.model_copy(update=coarse | {"tilts_deg": study.tilts_deg[::2]})


def test_a_search_finds_the_same_however_it_was_done(
    wanted: Path, searched: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec, store = read_requirements(wanted), tmp_path / "cut" / "store"
    script = tmp_path / "cut.py"
    script.write_text(CUT)
    running = subprocess.Popen([sys.executable, str(script), str(wanted), str(tmp_path / "cut")])
    for _ in range(600):
        if len(list(store.glob("press/*/*.h5"))) >= 6:
            break
        time.sleep(0.5)
    running.send_signal(signal.SIGKILL)
    running.wait()
    made = {path: path.stat().st_mtime_ns for path in store.glob("press/*/*.h5")}
    assert len(made) >= 6
    again = optimise_design(spec, tmp_path / "cut", workers=2)
    whole = optimise_design(spec, shutil.copytree(searched, tmp_path / "whole"), workers=2)
    assert again == whole
    assert all(path.stat().st_mtime_ns == when for path, when in made.items()), "nothing is pressed twice"
    monkeypatch.setattr(
        importlib.import_module("palpate.optimise.optimise_design"), "stage_version", lambda stage: "another"
    )
    assert optimise_design(spec, tmp_path / "cut", workers=2) == whole, "what was judged before is judged again"
    assert len(again.trials) == 3
    assert again.winner is not None
    assert again.winner.trial.feasible
    assert 0 < again.winner.value("error") < 0.5


def test_the_command_reports_and_its_winner_can_be_run(wanted: Path, searched: Path, tmp_path: Path) -> None:
    from palpate.cli import main

    shutil.copytree(searched / "store", tmp_path / "out" / "store")
    wanted.write_text(WANTED + "baseline_grid: {designs: {heights: [20], thicknesses: [2.5], markers: [7, 37]}}\n")
    more = ["--skins", "2", "--random-skins", "3", "--workers", "2", "--packs"]
    with pytest.raises(SystemExit) as left:
        main(["search", str(wanted), "--out", str(tmp_path / "out"), *more])
    assert left.value.code == 0
    page = (tmp_path / "out" / "report.md").read_text()
    assert f"palpate search {wanted} --out {tmp_path / 'out'} --skins 2 --random-skins 3 --packs\n" in page
    found = json.loads((tmp_path / "out" / "front.json").read_text())
    assert found["skins"] == 2
    assert found["winner"]["markers"] <= 37
    by_chance, grid = found["random_skins"]["chance"], found["random_skins"]["grid"]
    assert by_chance["p95_deg"] <= found["random_skins"]["search"]["p95_deg"], "the first skins are the same"
    assert (grid["thickness_mm"], grid["distance_mm"], grid["ring_diameters_mm"]) == (2.5, 48.0, "10 20 30")
    assert (tmp_path / "out" / "winner.svg").read_text().count("<path") > 20
    (skin,) = read_study(tmp_path / "out" / "winner.yaml").designs.skins()
    assert skin.height == found["winner"]["height_mm"]
    (pack,) = (tmp_path / "out" / "packs").iterdir()
    assert (pack / "instructions.pdf").is_file()
    assert json.loads((pack / "manifest.json").read_text())
    (tmp_path / "other.yaml").write_text(WANTED + "min_marker_diameter: 1.2\n")
    with pytest.raises(SystemExit) as left:
        main(["search", str(tmp_path / "other.yaml"), "--out", str(tmp_path / "out")])
    assert left.value.code == 2


@pytest.mark.slow(50)
def test_winner_and_rival_are_played_and_what_was_foreseen_stands_beside_it(
    wanted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small = partial(VirtualBenchSpec, cells=5, tilts=2, azimuths=2)
    monkeypatch.setattr(validation, "VirtualBenchSpec", small)
    monkeypatch.setattr(validation, "UNITS", 3)
    monkeypatch.setattr(validation, "design_study", coarse_study)
    monkeypatch.setattr(evaluation, "_COARSE_CONTACTS", ("no-slip", 1.2, 0.5))  # those around the frictions of units
    monkeypatch.setattr(
        validation, "plan_skin_evaluation", lambda *design, full: evaluation.plan_skin_evaluation(*design)
    )
    text = (
        WANTED.replace("skins: 3", "skins: 1")
        .replace("[2, 3]", "[2.5, 3]")
        .replace("calibration_presses: 2", "calibration_presses: 0")
    )
    wanted.write_text(text + "validation: trained\nbaseline: {thickness: 3, markers: {count: 19}}\n")
    spec, out = read_requirements(wanted), tmp_path / "out"
    front = validate_front(optimise_design(spec, out, workers=2), out, workers=2)
    made = {path: path.stat().st_mtime_ns for path in (out / "store").rglob("*.*")}
    proof = front.validation
    assert proof is not None, front.shortfall
    assert [one.title for one in proof.designs] == ["winner", "rival"]
    for one in proof.designs:
        assert one.simulated is not None
        assert (one.simulated.units, one.simulated.without_pose) == (3, 0)
        assert one.relative_error < 0.6, "three units on a coarse mesh"
        assert one.trained is not None
        assert (one.trained.units, one.trained.without_pose) == (3, 0)
        assert one.trained != one.simulated
        assert one.trained.rmse_deg < 1, "a sensor that always says upright would be off by 3.7"
    if proof.second is None:
        assert "CalculiX" in proof.second_problem
    else:
        assert proof.second.own_force_n == pytest.approx(proof.second.force_n, rel=0.1)
        assert proof.second.depth == pytest.approx(3.0)
        assert proof.second.markers_mm < 0.1
    write_front(out, front, "palpate search")
    page = (out / "report.md").read_text()
    check_values(page, "winner", "rival", "RMSE")
    assert validate_front(optimise_design(spec, out, workers=1), out, workers=1).validation == proof
    assert all(path.stat().st_mtime_ns == when for path, when in made.items()), "nothing is played twice"
    # the same units by the bench itself
    twin = find_artefact(
        ArtefactStore(out / "store"),
        validation.plan_skin_evaluation(spec, DomeSpec(thickness=3.0), spec.materials[0], full=True).twin,
    )
    bench = VirtualBench(
        small(units=3, max_tilt_deg=9.0, depth=3.0, min_depth=1.0),
        Design(DomeSpec(thickness=3.0), MarkerSpec(count=19), material=get_material(spec.materials[0])),
        twin,
        ArtefactStore(tmp_path / "bench"),
    )
    rx, ry, _ = (score.errors for score in pool_units(list(run_bench(bench))))
    rival = proof.designs[1].simulated
    assert rival is not None
    assert rival.rmse_deg == pytest.approx(((rx.rmse**2 + ry.rmse**2) / 2) ** 0.5, rel=1e-9)
    assert 0 < rival.p95_deg <= max(rx.max, ry.max)
