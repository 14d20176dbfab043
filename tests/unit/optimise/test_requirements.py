"""Requirements that contradict themselves or the workshop, and fronts by hand."""

import csv
import json
import math
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from errors import check_values, refused
from palpate.calibration import PredictedAccuracy
from palpate.core.store_lock import take_lock
from palpate.design import DomeSpec, MarkerSpec
from palpate.optimise import (
    Front,
    LayoutOption,
    RequirementsSpec,
    SkinEvaluation,
    SkinTrial,
    compute_sobol_indices,
    optimise_design,
    read_requirements,
)
from palpate.optimise.evaluate_skin import SkinEvaluationTask
from palpate.optimise.front import SearchBaselines
from palpate.optimise.optimise_design import _Evaluator, constraint_violations, objective_values
from palpate.optimise.space import SkinSpace
from palpate.optimise.validate_designs import _finalists
from palpate.optimise.write_front import report, winner_study, write_front
from palpate.study import read_study

WRONG = {
    "heights: [20, 10]": ("range-malformed", 20, 10, 2, 60),
    "heights: [10, 90]": ("range-malformed", 90, 2, 60),
    "depth: 12\nheights: [5, 11]": ("heights-below-depth", 11, 12),
    "min_depth: 8": ("depths-not-rising", "min_depth", 8),
    "max_marker_diameter: 0.8": ("marker-sizes-not-rising", "max_marker_diameter", 0.8, 1),
    "min_marker_diameter: 0.2": ("markers-not-printable", "min_marker_diameter", 0.2, 0.4),
    "materials: [cheese]": ("material-unknown", "cheese"),
    "cameras: []": ("list-empty", "cameras"),
    "objectives: [error, error]": ("list-entry-twice", "objectives", "error"),
    "objectives: [price]": ("price-without-choice", "price"),
    "objectives: [beauty]": ("literal_error", "objectives", "beauty"),
    "cameras:\n- name: eye\n  distances: [60, 40]": ("range-malformed", 60, 40),
    "cameras:\n- name: eye\n  camera: {width_px: 0}": ("greater_than_equal", "width_px"),
    "cameras:\n- name: eye": ("camera-unknown", "eye"),
    "cameras:\n- name: eye\n  distances: [40, 60]": ("camera-unknown", "davis346"),
    "makrers: 37": ("extra_forbidden", "makrers", "markers"),
    "force_n: -1": ("greater_than", "force_n", -1),
    "thicknesses: [2]": ("missing", "thicknesses"),
    "random_skins: -1": ("greater_than_equal", "random_skins", -1),
    "baseline_grid:\n  designs:\n    heights: [90]": ("less_than_equal", "baseline_grid.designs.heights", 90),
    "baseline_grid:\n  designs:\n    markers: [{file: dots.csv}]": ("layout-not-rings", "baseline_grid.designs"),
}


@pytest.mark.parametrize("line", WRONG)
def test_bad_requirements_are_one_sentence_with_the_line(tmp_path: Path, line: str) -> None:
    file = tmp_path / "wanted.yaml"
    file.write_text(f"name: wanted\n{line}\n")
    with refused(*WRONG[line]) as caught:
        read_requirements(file)
    assert f"{file}:" in str(caught.value)


def test_a_file_that_is_none_is_told(tmp_path: Path) -> None:
    for name, content, code in (
        ("none", None, "file-unreadable"),
        ("bytes", b"\xff\xfe", "file-not-text"),
        ("list", b"- 1\n", "yaml-not-mapping"),
        ("empty", b"", "yaml-not-mapping"),
    ):
        file = tmp_path / name
        if content is not None:
            file.write_bytes(content)
        with refused(code, file):
            read_requirements(file)


def test_a_folder_named_as_the_preset_does_not_hide_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "paper_task").mkdir()
    monkeypatch.chdir(tmp_path)
    assert read_requirements("paper_task").name == "paper_task"


def test_without_what_reads_images_nothing_is_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Skins of which no image could be read would all be told as such that cannot be made."""
    monkeypatch.setitem(sys.modules, "cv2", None)
    with refused("extra-missing", "OpenCV"):
        optimise_design(SPEC, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_second_search_in_a_folder_is_refused(tmp_path: Path) -> None:
    lock = take_lock(tmp_path / "search.lock")
    assert lock is not None
    with refused("search-running", str(tmp_path)):
        optimise_design(SPEC, tmp_path)
    lock.release()


def option(markers: int, worst: float) -> LayoutOption:
    rings = {7: (20.0,), 19: (10.0, 20.0), 37: (10.0, 20.0, 28.0)}[markers]
    figure = PredictedAccuracy(5, worst / 4, worst, 0.01, worst / 8)
    return LayoutOption(MarkerSpec(ring_diameters=rings), "davis346", 44.0, 0.0, figure)


def skin(number: int, height: float, force: float, *worst: float, reach: float = 8.0) -> SkinTrial:
    options = tuple(option(count, each) for count, each in zip((7, 19, 37), worst, strict=False))
    proposal = SkinEvaluation(DomeSpec(height=height), "zaid_2024_ecoflex_00_30", reach, force, None, options)
    return SkinTrial(number, proposal, constraint_violations(SPEC, proposal))


SPEC = RequirementsSpec(name="wanted", force_n=0.6, error_deg=0.2)
TRIED = (
    skin(0, 20, 0.5, 0.5, 0.3, 0.25),
    skin(1, 18, 0.55, 0.4, 0.2, 0.15),
    skin(2, 16, 0.7, 0.3, 0.1, 0.05),
    skin(3, 14, 0.4, 0.6, 0.5, 0.4, reach=7.0),
)


def test_the_winner_has_the_least_error_of_those_within_the_limits() -> None:
    front = Front(SPEC, TRIED)
    assert front.winner is not None
    assert (front.winner.trial.number, front.winner.option.markers.count) == (1, 37)
    assert front.shortfall == ""


def test_a_front_of_two_has_what_nothing_beats() -> None:
    front = Front(SPEC.model_copy(update={"objectives": ("error", "markers")}), TRIED)
    assert [(entry.trial.number, entry.option.markers.count) for entry in front.pareto] == [(1, 37), (1, 19), (1, 7)]
    forces = Front(SPEC.model_copy(update={"objectives": ("error", "force")}), TRIED)
    assert [entry.trial.number for entry in forces.pareto] == [1, 0]


def test_designs_by_coarse_presses_stay_on_the_front_and_are_marked(tmp_path: Path) -> None:
    """The only finalist is stiffer than skin 0, which no fine presses were made of."""
    spec = SPEC.model_copy(update={"objectives": ("error", "force"), "finalists": 1})
    front = Front(spec, (TRIED[0], replace(TRIED[1], fine=TRIED[1].coarse)))
    assert [entry.trial.number for entry in front.pareto] == [1]
    assert [entry.trial.number for entry in front.coarse_pareto] == [0]
    assert front.winner == front.pareto[0]
    write_front(tmp_path, front, "palpate search wanted.yaml")
    assert "front, coarse presses only" in (tmp_path / "front.svg").read_text()
    (row,) = (line for line in (tmp_path / "report.md").read_text().splitlines() if line.startswith("| 0 |"))
    check_values(row, "0.5")
    assert [row["skin"] for row in json.loads((tmp_path / "front.json").read_text())["coarse_front"]] == [0]
    with (tmp_path / "front.csv").open() as file:
        kept = {row["skin"]: row["full_fidelity"] for row in csv.DictReader(file)}
    assert kept == {"1": "True", "0": "False"}
    assert Front(SPEC, front.trials).coarse_pareto == (), "one objective: the best of the finalists counts"


def test_the_ends_of_a_front_are_no_worse_than_the_rival_and_each_is_played_once() -> None:
    several = SPEC.model_copy(update={"objectives": ("error", "force", "markers")})
    front = Front(several, TRIED, baseline=PredictedAccuracy(5, 0.06, 0.31, 0.01, 0.02))
    assert [(title, entry.trial.number, entry.option.markers.count) for title, entry in front.extremes] == [
        ("minimum force", 0, 37),
        ("fewest markers", 1, 19),
    ]
    assert Front(several, TRIED).error_threshold_deg == SPEC.error_deg, (
        "what is wanted counts where there is no rival"
    )
    assert [entry.trial.number for _, entry in Front(several, TRIED).extremes] == [1, 1]
    assert front.winner is not None
    assert [title for title, _ in _finalists(front, front.winner)] == ["winner", "minimum force", "fewest markers"]
    strict = Front(several, TRIED, baseline=PredictedAccuracy(5, 0.06, 0.16, 0.01, 0.02))
    assert [title for title, _ in _finalists(strict, front.winner)] == ["winner, minimum force, fewest markers"]
    assert Front(SPEC, TRIED).extremes == ()
    page = report(front, compute_sobol_indices(TRIED, SkinSpace.of(SPEC), 169), "palpate search wanted.yaml")
    check_values(page, "0.310°")
    (told,) = (line for line in page.splitlines() if line.startswith("* fewest markers"))
    check_values(told, 1, "H18 T2", 19, "1.5 mm")


def test_what_cannot_be_met_is_told_with_what_stands_in_the_way() -> None:
    hard = SPEC.model_copy(update={"error_deg": 0.1})
    check_values(Front(hard, TRIED).shortfall, "0.150°", "0.1°")
    none = Front(SPEC, (TRIED[2], TRIED[2], TRIED[3]))
    assert none.winner is None
    check_values(none.shortfall, "force", 2, 3, "12 %")


def test_the_report_says_how_it_was_made_and_the_winner_is_a_study(tmp_path: Path) -> None:
    front = Front(SPEC, TRIED)
    write_front(tmp_path, front, "palpate search wanted.yaml")
    assert {file.name for file in tmp_path.iterdir()} == {
        *("report.md", "front.csv", "tried.csv", "front.json", "search.svg", "front.svg", "winner.yaml", "winner.svg")
    }
    study = read_study(tmp_path / "winner.yaml")
    (dome,) = study.designs.skins()
    assert (dome.height, study.designs.markers[0].count, study.camera.distance) == (18.0, 37, 44.0)
    assert winner_study(front, front.winner) == (tmp_path / "winner.yaml").read_text()
    page = report(front, compute_sobol_indices(TRIED, SkinSpace.of(SPEC), 169), "palpate search wanted.yaml")
    check_values(page, 4, 2)


def test_a_finalist_that_breaks_a_limit_when_pressed_finely_is_followed_by_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of four skins that meet the limits by coarse presses the best two do not by fine ones."""
    tried = tuple(skin(number, 20.0 - number, 0.5, 0.5, 0.3, 0.1 + 0.01 * number) for number in range(4))
    short, asked = {20.0, 19.0}, list[float]()

    def press_finely(self: _Evaluator, tasks: Sequence[SkinEvaluationTask]) -> list[SkinEvaluation]:
        asked.extend(task.skin.height for task in tasks)
        coarse = [next(one.coarse for one in tried if one.coarse.skin == task.skin) for task in tasks]
        return [replace(one, max_depth_mm=7.9) if one.skin.height in short else one for one in coarse]

    monkeypatch.setattr(_Evaluator, "_do", press_finely)
    spec = SPEC.model_copy(update={"finalists": 2})
    front = Front(spec, tried)
    finished = replace(front, trials=_Evaluator(spec, tmp_path, None, None, "").finish(front))
    assert asked == [20.0, 19.0, 18.0, 17.0]
    assert finished.winner is not None
    assert finished.winner.trial.number == 2
    page = report(finished, compute_sobol_indices(tried, SkinSpace.of(spec), 169), "")
    for number in (0, 1):
        assert re.search(rf"\bSkin {number}\b", page)
    assert not re.search(r"\bSkin 2\b", page)


def test_the_report_holds_the_search_against_chance_and_a_grid(tmp_path: Path) -> None:
    """Only what meets the limits counts, and of finalists what coarse presses said, as of the others."""
    finalist = replace(TRIED[1], fine=skin(1, 18, 0.55, 0.9, 0.9, 0.9).coarse)
    front = Front(
        SPEC, (TRIED[0], finalist), search_baselines=SearchBaselines((TRIED[0], TRIED[2]), (TRIED[3], TRIED[0]))
    )
    write_front(tmp_path, front, "palpate search wanted.yaml")
    page = (tmp_path / "report.md").read_text()
    for name, *values_told in (
        ("search", 2, "H18 T2", 37, "0.1500°"),
        ("chance", 2, "H20 T2", 37, "0.2500°"),
        ("grid", 6, "H20 T2", 37, "0.2500°"),
    ):
        (told,) = (line for line in page.splitlines() if line.startswith(f"* {name},"))
        check_values(told, *values_told)
    control = json.loads((tmp_path / "front.json").read_text())["random_skins"]
    assert [control[name]["p95_deg"] for name in ("search", "chance", "grid")] == [0.15, 0.25, 0.25]
    picture = (tmp_path / "search.svg").read_text()
    check_values(picture, "random search", "H20 T2", 37)
    alone = report(Front(SPEC, TRIED), compute_sobol_indices(TRIED, SkinSpace.of(SPEC), 169), "")
    assert not any(line.startswith(("* chance,", "* grid,")) for line in alone.splitlines())


def spread_skins(error_deg: Callable[[int, float], float]) -> tuple[SkinSpace, list[SkinTrial]]:
    """Sixty skins all over a space, their errors by number and height."""
    space, tried = SkinSpace.of(SPEC.model_copy(update={"aspects": (1.0, 1.0)})), []
    for number in range(60):
        share = [(number * step) % 1.0 for step in (0.618, 0.414, 0.732)]
        place = {
            name: low + part * (high - low)
            for part, (name, (low, high)) in zip(share, space.ranges.items(), strict=True)
        }
        found = option(37, error_deg(number, place["height"]))
        tried.append(
            SkinTrial(number, SkinEvaluation(space.skin(place), "m", 8.0, 0.5, None, (found,)), {"reach": -0.01})
        )
    return space, tried


def test_what_matters_is_found_where_it_is_known() -> None:
    """Error by height alone, as a law says it: thickness and radius have no share."""
    space, tried = spread_skins(lambda _, height: 10 ** (height / 20 - 2))
    found = compute_sobol_indices(tried, space, 169)
    assert found.explained > 0.98
    assert found.variables[0].name == "height"
    assert found.variables[0].total == pytest.approx(1.0, abs=0.05)
    assert all(abs(one.total) < 0.05 for one in found.variables[1:])
    assert "height" in found.summary


def test_nothing_matters_where_no_surface_goes_through_the_skins() -> None:
    """Errors by chance alone: their surface has indices like any other, and they mean nothing."""
    chance = np.random.default_rng(0).uniform(-1.5, -0.5, 60)
    space, tried = spread_skins(lambda number, _: 10 ** chance[number])
    found = compute_sobol_indices(tried, space, 169)
    assert found.explained < 0.2
    assert max(one.total for one in found.variables) > 0.15
    assert not any(one.name in found.summary for one in found.variables)


def test_skins_that_fall_short_of_the_depth_do_not_say_what_matters() -> None:
    space, tried = spread_skins(lambda number, height: 1.0 if number % 7 == 0 else 10 ** (height / 20 - 2))
    assert compute_sobol_indices(tried, space, 169).explained < 0.5
    short = [replace(one, violations={"reach": 0.2}) if one.number % 7 == 0 else one for one in tried]
    assert compute_sobol_indices(short, space, 169).explained > 0.98


def test_what_is_not_known_of_a_skin_is_told_as_such() -> None:
    # a skin that jumps was told as one of 3 degrees and 0.001 N, and the search went by the latter
    spec = SPEC.model_copy(update={"objectives": ("error", "force", "markers")})
    jumps = SkinEvaluation(DomeSpec(), "zaid_2024_ecoflex_00_30", problem="8 of 16 presses jump to another state")
    assert objective_values(spec, jumps) == (math.inf, math.inf)
    assert constraint_violations(spec, jumps)["made"] > 0
    unread = SkinEvaluation(DomeSpec(), "zaid_2024_ecoflex_00_30", 8.0, 0.5)
    assert objective_values(spec, unread) == (math.inf, math.log10(0.5))
    assert objective_values(SPEC, skin(0, 20.0, 0.5, 0.3, 0.2).coarse)[0] == math.log10(0.2)
