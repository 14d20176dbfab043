"""`palpate design deck` and the solver and export of `palpate press`."""

import json
from pathlib import Path

import pytest

from errors import check_refusal
from palpate.cli import main


def call(*words: str | Path) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    assert isinstance(left.value.code, int)
    return left.value.code


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        ((), "C3D20RH"),
        (("--dialect", "abaqus", "--element", "shell"), "S4R"),
        (("--dialect", "calculix"), "C3D20R,"),
    ],
)
def test_deck_writes_the_file_it_is_asked_for(words: tuple[str, ...], kind: str, tmp_path: Path) -> None:
    path = tmp_path / "press.inp"
    assert (
        call(
            "design", "deck", *words, "--height", "20", "--thickness", "3", "--tilt", "5", "--cells", "5", "-o", path
        )
        == 0
    )
    text = path.read_text()
    assert f"*ELEMENT, TYPE={kind}" in text
    assert "height 20 mm, base radius 20 mm, thickness 3 mm" in text
    assert "tilt 5 deg" in text


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--dialect", "nastran"), ("usage", "--dialect", "nastran")),
        (("--element", "beam"), ("usage", "--element", "beam")),
        (("--dialect", "calculix", "--element", "shell"), ("deck-shell-stiff", "--element solid")),
        (("--material", "cheese"), ("material-unknown", "--material", "cheese")),
        (("--tilt", "50"), ("less_than_equal", "--tilt", 50)),
        (("--contact", "sticky"), ("contact-unknown", "--contact", "sticky")),
    ],
)
def test_bad_input_is_refused_and_nothing_written(
    words: tuple[str, ...], says: tuple[object, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call("design", "deck", *words, "--cells", "5", "-o", tmp_path / "press.inp") == 2
    check_refusal(capsys.readouterr().err, *says)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("design", "deck", "--cells", "5", "-o", tmp_path / "no" / "press.inp") == 2
    check_refusal(capsys.readouterr().err, "folder-missing", tmp_path / "no")


def test_press_exports_what_it_solved(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("press", "--depth", "0.8", "--cells", "5", "--json", "--export", tmp_path / "out") == 0
    assert len(json.loads(capsys.readouterr().out)["images"]) == 2
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "press_0000.vtu",
        "press_0001.vtu",
        "press.pvd",
        "force.csv",
        "contact.csv",
    }


def test_a_folder_that_exists_is_refused_before_anything_is_solved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call("press", "--export", tmp_path) == 2
    check_refusal(capsys.readouterr().err, "folder-exists", tmp_path)


def test_a_missing_ccx_is_refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("PATH", "")
    assert call("press", "--solver", "calculix") == 2
    check_refusal(capsys.readouterr().err, "solver-missing", "apt install calculix-ccx")
