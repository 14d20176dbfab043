"""The folder of a search, read while it runs and when it is finished."""

import json
from pathlib import Path

import pytest

from palpate.core import PalpateError
from palpate.optimise import is_search, read_search
from palpate.optimise.optimise_design import JOURNAL
from small_search import MATERIAL, SPEC, write_search

pytest.importorskip("optuna")
pytest.importorskip("torch")


def test_a_running_search_shows_what_was_tried_so_far(tmp_path: Path) -> None:
    front = write_search(tmp_path, finished=False)
    found = read_search(tmp_path)
    assert (found.skins, found.finished, found.front) == (8, False, len(front.best))
    assert len(found.rows) == found.front + 8
    assert front.winner is not None
    assert found.rows[found.winner]["skin"] == front.winner.tried.number
    assert {row["skin"] for row in found.rows[found.front :]} == set(range(8))


def test_a_line_that_is_being_written_is_left_for_the_next_time(tmp_path: Path) -> None:
    write_search(tmp_path, finished=False)
    journal = tmp_path / JOURNAL
    lines = journal.read_text().splitlines(keepends=True)
    last = next(k for k in reversed(range(len(lines))) if '"values"' in lines[k])
    journal.write_text("".join(lines[:last]) + lines[last][:40])
    assert read_search(tmp_path).skins == 7


def test_a_finished_search_shows_its_front_until_it_goes_on(tmp_path: Path) -> None:
    front = write_search(tmp_path, finished=True)
    found = read_search(tmp_path)
    written = json.loads((tmp_path / "front.json").read_text())
    assert found.finished
    assert list(found.rows[: found.front]) == written["front"]
    assert found.rows[found.winner] == written["winner"]
    assert found.front == len(front.best) > 3
    written["skins"] = 4
    (tmp_path / "front.json").write_text(json.dumps(written))
    assert not read_search(tmp_path).finished


def test_a_design_has_the_parts_that_were_found(tmp_path: Path) -> None:
    front = write_search(tmp_path, finished=True)
    found = read_search(tmp_path)
    for number, entry in enumerate(front.best):
        design = found.design(number)
        assert (design.skin, design.material) == (entry.tried.known.skin, MATERIAL)
        assert design.markers == entry.option.markers
        assert design.camera == SPEC.cameras[0].camera.model_copy(update={"distance": 44.0})
    with pytest.raises(PalpateError, match="There is no design 999"):
        found.design(999)


def test_a_folder_of_something_else_or_a_broken_one_is_told(tmp_path: Path) -> None:
    assert not is_search(tmp_path)
    with pytest.raises(PalpateError, match="holds no search"):
        read_search(tmp_path)
    write_search(tmp_path, finished=True)
    (tmp_path / "front.json").write_text("{")
    with pytest.raises(PalpateError, match="cannot be read"):
        read_search(tmp_path)
