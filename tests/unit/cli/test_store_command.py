import json
from pathlib import Path

import pytest

from errors import check_refusal, check_values
from palpate.cli import main
from palpate.core import ArtefactStore, Recipe
from palpate.study import read_study
from palpate.study.plan import plan_study


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A result folder with a press of the preset `first`, and one of no study."""
    store = ArtefactStore(tmp_path / "store")
    press = plan_study(read_study("first")).tasks()[0]
    for recipe in (press.recipe, Recipe("press", "of no study")):
        store.write(recipe, lambda path: path.write_text("content") and None)
    return tmp_path


def run(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    shown = capsys.readouterr()
    assert isinstance(left.value.code, int)
    return left.value.code, shown.out, shown.err


def names(out: Path) -> list[str]:
    return sorted(path.name for path in (out / "store").rglob("*.h5"))


def test_store_check_leaves_with_one_where_something_is_broken(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, shown, _ = run(capsys, "study", "store", "check", out, "--json")
    assert (code, json.loads(shown)["broken"]) == (0, [])
    broken = next((out / "store").rglob("*.h5"))
    broken.write_text("contenT")
    code, shown, _ = run(capsys, "study", "store", "check", out, "--json")
    assert code == 1
    assert [each["path"] for each in json.loads(shown)["broken"]] == [str(broken)]


def test_store_gc_says_first_and_removes_then(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = names(out)
    code, shown, _ = run(capsys, "study", "store", "gc", out, "first", "--dry-run")
    assert (code, names(out)) == (0, before)
    check_values(shown, 2)
    code, shown, _ = run(capsys, "study", "store", "gc", out, "first", "--json")
    assert code == 0
    assert len(json.loads(shown)["removed"]) == 2
    assert names(out) == [f"{plan_study(read_study('first')).tasks()[0].recipe.key}.h5"]


def test_store_gc_without_a_study_removes_nothing(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, output = run(capsys, "study", "store", "gc", out)
    assert code == 2
    check_refusal(output, "argument-missing")
    assert len(names(out)) == 2


@pytest.mark.parametrize(
    "words", [["study", "store", "check"], ["study", "store", "gc"], ["status", "first", "--out"]]
)
def test_a_folder_without_artefacts_is_bad_input(
    tmp_path: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, output = run(capsys, *words, tmp_path / "none")
    assert code == 2
    check_refusal(output, ("folder-not-results", "study-folder-empty"), tmp_path / "none")


def test_status_says_how_much_is_made(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, shown, _ = run(capsys, "study", "status", "first", "--out", out, "--json")
    assert code == 0
    output = json.loads(shown)
    assert (output["made"], output["of"]) == (1, 64)
    assert output["kinds"]["press"]["made"] == 1
    code, shown, _ = run(capsys, "study", "status", "first", "--out", out)
    assert "press" in shown


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--workers", "0"], ("option-out-of-bounds", "--workers", 0)),
        (["--timeout", "0"], ("option-out-of-bounds", "--timeout", 0)),
        (["--timeout", "nan"], ("option-out-of-bounds", "--timeout", "nan")),
        (["--cluster", "moon"], ("cluster-malformed", "moon", "local:N")),
        (["--cluster", "local:0"], ("cluster-malformed", "local:0")),
        (["--cluster", "tcp://"], ("cluster-malformed", "tcp://")),
        (["--cluster", "file:///etc/passwd"], ("cluster-malformed", "file:///etc/passwd")),
        (["--cluster", "local:2", "--workers", "2"], ("options-exclusive", "--workers", "--cluster")),
    ],
)
def test_run_refuses_hands_that_cannot_be_meant(
    words: list[str], says: tuple[object, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, output = run(capsys, "run", "first", "--out", tmp_path / "out", *words)
    assert code == 2
    check_refusal(output, *says)
    assert not (tmp_path / "out").exists()
