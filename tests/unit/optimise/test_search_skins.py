"""The search on a stand-in whose optimum is known: against chance, cut off and gone on with."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from palpate.optimise import Evaluation, RequirementsSpec, SearchPlan, SkinSpace, search_skins
from palpate.optimise.search_skins import Sampler, read_trials, rewrite_journal
from palpate.optimise.space import Place

pytest.importorskip("optuna")
pytest.importorskip("torch")

SPACE = SkinSpace(
    {"height": (10.0, 30.0), "thickness": (1.0, 4.0), "aspect": (0.6, 1.6)}, {"base_radius": 20.0}, ("a",)
)
LEAST = 0.02
"""Value of the stand-in at its optimum, which lies on the edge of what its constraint allows."""


def error(place: Place) -> float:
    x = np.array([(place["height"] - 17) / 20, (place["thickness"] - 1.6) / 3, place["aspect"] - 1.2])
    return LEAST + float(x @ x) + 0.3 * abs(float(x[0] * x[2])) + 0.3 * max(0.0, 2.0 - float(place["thickness"]))


def judge(places: Sequence[Place]) -> list[Evaluation]:
    return [
        Evaluation((float(np.log10(error(place))),), {"force": float(1.6 - place["thickness"])}, {})
        for place in places
    ]


def least(tried) -> float:
    return min(10 ** one.evaluation.values[0] for one in tried if one.evaluation.violations["force"] <= 0)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 5))])
def test_it_finds_more_than_chance_at_the_same_cost(tmp_path: Path, seed: int) -> None:
    found = [
        least(search_skins(SPACE, judge, SearchPlan(28, seed, sampler), tmp_path / sampler))
        for sampler in ("gp", "random")
    ]
    assert found[0] < found[1]


def test_it_comes_within_a_twentieth_of_a_search_ten_times_as_long(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    drawn = rng.uniform(*np.array(list(SPACE.ranges.values())).T, (200_000, 3))
    true = min(error(dict(zip(SPACE.ranges, row, strict=True))) for row in drawn[drawn[:, 1] >= 1.6][:20_000])
    assert least(search_skins(SPACE, judge, SearchPlan(44), tmp_path / "journal")) <= 1.05 * true


@pytest.mark.parametrize(("told", "better"), [(math.inf, True), (1.5, False)])
def test_skins_of_which_nothing_is_known_do_not_hide_how_the_others_differ(
    tmp_path: Path, told: float, better: bool
) -> None:
    # of real skins errors differ by a tenth, and one that jumped was once told as one of three degrees
    def judge_some(places: Sequence[Place]) -> list[Evaluation]:
        found = [(place["thickness"] < 1.3, one) for place, one in zip(places, judge(places), strict=True)]
        return [
            Evaluation(
                (told if jumps else 0.05 * one.values[0],), {**one.violations, "made": 1.0 if jumps else -1.0}, {}
            )
            for jumps, one in found
        ]

    found = min(
        10 ** (one.evaluation.values[0] / 0.05)
        for one in search_skins(SPACE, judge_some, SearchPlan(24, 1), tmp_path / "journal")
        if max(one.evaluation.violations.values()) <= 0
    )
    assert (found < 4 * LEAST) == better


@pytest.mark.parametrize("sampler", ["gp", "random"])
def test_a_journal_written_anew_goes_on_as_the_old_one_would(tmp_path: Path, sampler: Sampler) -> None:
    plan, whole, cut = SearchPlan(12, 3, sampler), tmp_path / "whole", tmp_path / "cut"
    expected = search_skins(SPACE, judge, plan, whole)
    tried = search_skins(SPACE, judge, replace(plan, trials=8), cut)
    rewrite_journal(cut, SPACE, plan, tried)
    assert read_trials(cut) == tried
    assert search_skins(SPACE, judge, plan, cut) == expected
    # and by other values, it goes on otherwise where it goes by them
    other = [replace(one, evaluation=replace(one.evaluation, values=(one.place["aspect"],))) for one in tried]
    rewrite_journal(cut, SPACE, plan, other)
    found = search_skins(SPACE, judge, plan, cut)
    assert (found[8:] == expected[8:]) == (sampler == "random")


@pytest.mark.parametrize("known", [0, 1])
def test_two_objectives_are_searched_where_hardly_anything_is_known(tmp_path: Path, known: int) -> None:
    def judge_few(places: Sequence[Place]) -> list[Evaluation]:
        first = [known and not calls for _ in places]
        calls.append(len(places))
        return [
            Evaluation(
                (error(place), place["thickness"]) if one else (math.inf, math.inf),
                {"made": -1.0 if one else 1.0},
                {},
            )
            for one, place in zip(first, places, strict=True)
        ]

    calls: list[int] = []
    found = search_skins(SPACE, judge_few, SearchPlan(14, 1, n_objectives=2), tmp_path / "journal")
    assert calls == [4, 4, 4, 2]
    assert len({tuple(one.place.values()) for one in found}) > 10, "it goes on looking elsewhere"
    assert read_trials(tmp_path / "journal", 2) == found


def test_whoever_watches_is_told_after_every_batch(tmp_path: Path) -> None:
    told: list[int] = []
    search_skins(
        SPACE, judge, SearchPlan(6, 1, "random"), tmp_path / "journal", lambda tried: told.append(len(tried))
    )
    assert told == [4, 6]


class CutError(Exception):
    pass


@pytest.mark.parametrize("when", [1, 3])
def test_a_search_that_was_cut_off_tries_what_it_would_have_tried(tmp_path: Path, when: int) -> None:
    plan = SearchPlan(14, seed=3, initial=({"height": 20.0, "thickness": 2.0, "aspect": 1.0},))
    whole = search_skins(SPACE, judge, plan, tmp_path / "whole")
    calls = []

    def cut(places: Sequence[Place]) -> list[Evaluation]:
        calls.append(list(places))
        if len(calls) == when + 1:
            raise CutError
        return judge(places)

    with pytest.raises(CutError):
        search_skins(SPACE, cut, plan, tmp_path / "cut")
    again = search_skins(SPACE, judge, plan, tmp_path / "cut")
    assert [one.place for one in again] == [one.place for one in whole]
    assert whole[0].place == plan.initial[0]


def test_nothing_is_judged_twice_and_a_longer_search_goes_on(tmp_path: Path) -> None:
    judged = []

    def count(places: Sequence[Place]) -> list[Evaluation]:
        judged.extend(places)
        return judge(places)

    short = search_skins(SPACE, count, SearchPlan(8), tmp_path / "journal")
    longer = search_skins(SPACE, count, SearchPlan(14), tmp_path / "journal")
    assert len(judged) == len(longer) == 14
    assert longer[:8] == short


def test_rounded_places_are_skins_that_can_be_drawn() -> None:
    skin = SPACE.skin({"height": 17.123, "thickness": 1.618, "aspect": 1.234})
    assert skin.model_dump(exclude={"kind"}) == {
        "height": 17.1,
        "base_radius": 20.0,
        "thickness": 1.6,
        "aspect": 1.24,
    }
    assert "kind" not in SPACE.skin({"height": 17.0, "thickness": 1.6, "aspect": 1.004}).model_dump()


def test_walls_taper_where_they_may() -> None:
    ranges = {"height": (10.0, 30.0), "taper": (0.8, 1.6)}
    space = SkinSpace(ranges, {"base_radius": 20.0, "thickness": 2.0, "aspect": 1.0}, ("a",))
    skin = space.skin({"height": 20.0, "taper": 1.27})
    assert skin.build().rim_thickness == pytest.approx(2.5)
    assert space.place(skin) == {"height": 20.0, "taper": 1.25}
    assert SkinSpace.of(RequirementsSpec()).fixed["taper"] == 1.0
