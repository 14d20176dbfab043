"""The folder of a search, read while it runs and when it is finished."""

import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from errors import refused
from palpate.core import stage_version
from palpate.design import DomeSpec
from palpate.material import get_material
from palpate.optimise import Evaluation, SearchPlan, SkinEvaluation, SkinSpace, is_search, read_search, search_skins
from palpate.optimise.optimise_design import (
    ASKED,
    JOURNAL,
    _evaluation_version,
    _Evaluator,
    constraint_violations,
    objective_values,
)
from palpate.optimise.space import Place
from small_search import MATERIAL, SPEC, propose, write_search

pytest.importorskip("optuna")
pytest.importorskip("torch")


def test_a_running_search_shows_what_was_tried_so_far(tmp_path: Path) -> None:
    front = write_search(tmp_path, finished=False)
    found = read_search(tmp_path)
    assert (found.skins, found.finished, found.front) == (8, False, len(front.pareto))
    assert len(found.rows) == found.front + 8
    assert front.winner is not None
    assert found.rows[found.winner]["skin"] == front.winner.trial.number
    assert {row["skin"] for row in found.rows[found.front :]} == set(range(8))


def test_a_search_goes_on_by_what_is_said_now_of_skins_tried_before(tmp_path: Path) -> None:
    # the third jumped, and an earlier version told it as one of three degrees and 0.001 N
    space, plan, journal = SkinSpace.of(SPEC), SearchPlan(8, 3, "random", n_objectives=2), tmp_path / JOURNAL
    jumps = SkinEvaluation(DomeSpec(), MATERIAL, problem="8 of 16 presses jump to another state")
    drawn: list[Place] = []

    def judge(places: Sequence[Place]) -> list[Evaluation]:
        drawn.extend(places)
        found = [(0.477, -3.0, jumps) if place is drawn[2] else (-1.0, -0.5, propose(place)) for place in places]
        return [
            Evaluation(
                (error, force),
                constraint_violations(SPEC, one),
                {"proposal": one.to_data(), "version": _evaluation_version()},
            )
            for error, force, one in found
        ]

    before = search_skins(space, judge, plan, journal)
    again = _Evaluator(SPEC, tmp_path, None, None, "").search(space, plan, journal)
    assert [one.place for one in again] == [one.place for one in before] == drawn
    assert again[2].evaluation.values == (math.inf, math.inf)
    assert all(
        one.evaluation.values == objective_values(SPEC, SkinEvaluation.from_data(one.evaluation.record["proposal"]))
        for one in again
    )
    (tmp_path / ASKED).write_text(SPEC.model_dump_json())
    assert read_search(tmp_path).skins == 8
    told = journal.read_bytes()
    assert _Evaluator(SPEC, tmp_path, None, None, "").search(space, plan, journal) == again
    assert journal.read_bytes().startswith(told), "a journal that says what is said now is not written anew"
    assert not list(tmp_path.glob("*.new*"))


@pytest.mark.parametrize("stage", ["skin_evaluation", "twin", "press"])
def test_skins_are_evaluated_again_where_a_stage_behind_them_changes(
    monkeypatch: pytest.MonkeyPatch, stage: str
) -> None:
    before = _evaluation_version()

    def changed(name: str) -> str:
        return stage_version(name) + "!" * (name == stage)

    monkeypatch.setattr(sys.modules[_Evaluator.__module__], "stage_version", changed)
    assert _evaluation_version() != before


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
    assert found.front == len(front.pareto) > 3
    written["skins"] = 4
    (tmp_path / "front.json").write_text(json.dumps(written))
    assert not read_search(tmp_path).finished


def test_a_design_has_the_parts_that_were_found(tmp_path: Path) -> None:
    front = write_search(tmp_path, finished=True)
    found = read_search(tmp_path)
    for number, entry in enumerate(front.pareto):
        design = found.design(number)
        assert (design.skin_spec, design.material) == (entry.trial.finest.skin, get_material(MATERIAL))
        assert design.markers == entry.option.markers
        assert design.camera_spec == SPEC.cameras[0].camera.model_copy(update={"distance": 44.0})
    with refused("design-unknown", "999"):
        found.design(999)


def test_a_folder_of_something_else_or_a_broken_one_is_told(tmp_path: Path) -> None:
    assert not is_search(tmp_path)
    with refused("search-missing"):
        read_search(tmp_path)
    write_search(tmp_path, finished=True)
    (tmp_path / "front.json").write_text("{")
    with refused("search-unreadable"):
        read_search(tmp_path)
