"""Without --model a sensor is read by the twin of the design that its flags name, wherever one was kept."""

import json
import os
import shlex
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from doors import furnish, still_twin

from errors import check_refusal, check_values
from palpate.cli import main
from palpate.core import PalpateError
from palpate.design import DomeSpec, EllipsoidSpec, MarkerSpec, build_skin
from palpate.material import get_material
from palpate.study import AsBuiltSpec, MaterialSpec, single_design_study
from palpate.surrogate import Twin, find_twin, twin_path, write_twin
from palpate.surrogate.twin_file import material_text

SKIN = build_skin(DomeSpec())
ECOFLEX = MaterialSpec().material()


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    return int(str(left.value.code))


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return furnish(tmp_path_factory.mktemp("house"))


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def keep(folder: str, twin: Twin, age_s: float = 0.0) -> Path:
    path = twin_path(Path("results") / folder, twin.skin)
    path.parent.mkdir(parents=True)
    write_twin(path, twin)
    os.utime(path, (1e9 - age_s, 1e9 - age_s))
    return path


@pytest.mark.parametrize(
    ("command", "at"), [("live", "--source images --markers 37"), ("accept", "images/truth.csv --markers 37")]
)
def test_a_sensor_is_read_by_the_twin_of_its_design(command, at, house, capsys) -> None:
    path = keep("study", still_twin(SKIN))
    words = at.replace("images", str(house["images"])).split()
    assert run(command, *words, *([] if command == "live" else ["--no-zero", "--min-depth", "0"])) in (0, 1)
    check_values(capsys.readouterr().err, path)


@pytest.mark.parametrize("command", ["live", "accept", "identify"])
def test_without_a_twin_the_command_that_makes_it_is_said_and_nothing_is_computed(command, house, capsys) -> None:
    keep("other", still_twin(build_skin(DomeSpec(height=10))))
    words = ["--source", house["images"]] if command == "live" else [house["truth"]]
    design = ["--thickness", "1.5", "--markers", "37", "--skin", "ellipsoid:aspect=0.8", "--material", "yeoh:1,1,1"]
    assert run(command, *words, *design) == 2
    said = capsys.readouterr().err
    check_refusal(said, "twin-missing", "ellipsoid 0.8 H20 T1.5", "yeoh:1,1,1", "results/*/twins")
    made = shlex.split(said.split("palpate calibration predict ")[1].removesuffix(" [twin-missing]\n"))
    assert sorted(made) == sorted([*design, "--height", "20"])
    assert not (Path("results") / "ellipsoid_0.8_H20_T1.5_yeoh_1_1_1").exists()


def test_the_best_twin_of_skin_and_material_reads_whenever_it_was_written() -> None:
    mine = replace(still_twin(SKIN), material=material_text(ECOFLEX), interpolation_error_mm=0.02)
    keep("a_rough", mine, age_s=-10)
    fine = keep("b_fine", replace(mine, interpolation_error_mm=0.01), age_s=10)
    keep("c_as_fine", replace(mine, interpolation_error_mm=0.01))
    keep("d_unsaid", replace(mine, interpolation_error_mm=0.0, material=""))
    keep("e_unchecked", replace(mine, interpolation_error_mm=np.nan))
    keep("f_stiff", replace(mine, material=material_text(get_material("yeoh:1,1,1"))), age_s=-10)
    broken = twin_path(Path("results") / "broken", SKIN)
    broken.parent.mkdir(parents=True)
    broken.write_text("no twin")
    old = keep("old", mine)
    with h5py.File(old, "a") as file:
        file.attrs["version"] = "0"
    told: list[PalpateError] = []
    assert find_twin(Path("results"), SKIN, ECOFLEX, told.append) == fine
    assert len(told) == 2
    assert all(any(str(path) in error.problem for error in told) for path in (broken, old))
    assert find_twin(Path("results"), build_skin(DomeSpec(thickness=1)), ECOFLEX) is None
    assert find_twin(Path("nowhere"), SKIN, ECOFLEX) is None


def test_a_twin_that_is_passed_over_is_named(house, capsys) -> None:
    keep("good", still_twin(SKIN))
    broken = twin_path(Path("results") / "broken", SKIN)
    broken.parent.mkdir(parents=True)
    broken.write_text("no twin")
    words = ["sensor", "live", "--source", house["images"], "--markers", "37"]
    assert run(*words) == 0
    assert str(broken) in capsys.readouterr().err


def test_a_bench_makes_the_twin_that_is_missing(monkeypatch, capsys) -> None:
    import palpate.study

    asked = []

    def run_twins(study, folder, **_):
        asked.append((study, folder))
        raise KeyboardInterrupt

    monkeypatch.setattr(palpate.study, "run_twins", run_twins)
    with pytest.raises((SystemExit, KeyboardInterrupt)):
        main(["simulation", "bench", "--markers", "37", "--out", "new"])
    check_values(capsys.readouterr().err, "H20 T2")
    study, folder = asked[0]
    assert folder == Path("results") / "H20_T2"
    assert study == single_design_study(DomeSpec(), MarkerSpec(count=37), MaterialSpec())


def test_a_design_is_a_study_of_its_own() -> None:
    skin = EllipsoidSpec(height=15, aspect=0.8)
    study = single_design_study(skin, MarkerSpec(count=37), MaterialSpec(name="yeoh:1,1,1"))
    assert study.designs.skins() == (skin,)
    assert study.designs.markers == (MarkerSpec(count=37),)
    assert study.name == "ellipsoid_0.8_H15_T2_yeoh_1_1_1"
    assert study.built == AsBuiltSpec()
    json.dumps(study.model_dump(mode="json"))


def test_a_study_and_flags_of_a_design_contradict_each_other(capsys) -> None:
    assert run("calibration", "predict", "first", "--height", "10") == 2
    check_refusal(capsys.readouterr().err, "options-exclusive", "first")


def test_a_bench_refuses_a_pad_before_it_announces_a_twin(capsys) -> None:
    assert run("simulation", "bench", "--skin", "pad:", "--markers", "7", "--out", "new") == 2
    shown = capsys.readouterr().err
    assert "minutes" not in shown
    check_values(shown, "twin-needs-revolution", "--model")


def test_a_wrong_tolerance_is_named_as_one(capsys) -> None:
    assert run("calibration", "predict", "--tolerance", "thickness=-1") == 2
    check_values(capsys.readouterr().err, "--tolerance: thickness is -1", "tolerance-out-of-bounds")
