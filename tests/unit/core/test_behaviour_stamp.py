"""The version of an artefact follows the results of its stage, the numeric libraries, and the plug-ins."""

import json
from pathlib import Path

import pytest

from errors import refused
from palpate.core import behaviour, stage_version
from palpate.design import Design
from palpate.fea import WallSpec
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec
from palpate.study import PressTask


@pytest.fixture(autouse=True)
def _nothing_is_remembered():
    for function in (behaviour.behaviour_stamp, behaviour._library_versions, behaviour._package_version):
        function.cache_clear()
    yield
    for function in (behaviour.behaviour_stamp, behaviour._library_versions, behaviour._package_version):
        function.cache_clear()


def key_of_a_press() -> str:
    return PressTask(Design(), MeshSpec(), WallSpec(), SolverSpec()).recipe.key


def test_another_result_of_a_stage_gives_another_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = key_of_a_press()
    results = json.loads(behaviour.BEHAVIOUR_FILE.read_text())
    changed = tmp_path / "behaviour.json"
    monkeypatch.setattr(behaviour, "BEHAVIOUR_FILE", changed)
    results["twin"]["tilted"]["force"][0] += 1e-3
    changed.write_text(json.dumps(results))
    behaviour.behaviour_stamp.cache_clear()
    assert key_of_a_press() == before, "another stage"
    results["press"]["no slip"]["force"][-1] *= 1.01
    changed.write_text(json.dumps(results))
    behaviour.behaviour_stamp.cache_clear()
    assert key_of_a_press() != before


@pytest.mark.parametrize("library", ["numpy", "scipy", "numba", "py-mkl-pardiso", "rslab"])
def test_another_version_of_a_library_gives_another_key(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    installed = behaviour.installed_version
    before = key_of_a_press()
    monkeypatch.setattr(behaviour, "installed_version", lambda name: "99" if name == library else installed(name))
    behaviour._library_versions.cache_clear()
    assert key_of_a_press() != before


def test_a_class_of_another_package_adds_its_version() -> None:
    class Guest:
        __module__ = "pytest.guest"

    assert stage_version("press", WallSpec(), 1.0) == stage_version("press")
    assert stage_version("press", Guest()) == f"{stage_version('press')}; pytest {pytest.__version__}"


def test_a_stage_without_reference_cases_is_refused() -> None:
    with refused("stage-unknown", "cooking", "press"):
        stage_version("cooking")
