"""Studies of barrels: what is planned, and what they can not have."""

from pathlib import Path

import pytest

from errors import refused
from palpate.study import Study, read_study
from palpate.study.plan import plan_study
from palpate.study.task import PressTask

BARREL = {
    "name": "a",
    "designs": {
        "skin": {"kind": "barrel", "middle_radius": 50},
        "heights": [260],
        "thicknesses": [3.361],
        "base_radius": 32.804,
        "markers": [{"rows": 4, "around": 8, "pitch": 30}],
    },
    "obstacle": {"kind": "side_wall", "depth": 3, "depth_step": 0.5, "contact": 0.6},
    "tilts_deg": [88, 92],
}


def test_the_preset_presses_its_side_at_every_tilt_and_looks_for_no_other_state() -> None:
    plan = plan_study(read_study("barrel"))
    presses = [task for task in plan.tasks() if isinstance(task, PressTask)]
    assert [press.obstacle.radial for press in presses] == list(read_study("barrel").tilts_deg)
    assert all(press.obstacle.sideways and press.obstacle.friction == 0.6 for press in presses)
    assert [task.recipe.kind for task in plan.tasks()].count("press") == len(presses)
    assert plan.designs[0].dataset.design.markers.count == 256
    assert presses[0].name == "press barrel 50 H260 B32.804 T3.361 tilt 85° friction 0.6"


def test_the_study_at_the_root_is_the_preset() -> None:
    root = Path(__file__).parents[3]
    assert read_study(root / "studies" / "barrel.yaml") == read_study("barrel")


def test_the_kind_of_an_obstacle_is_written() -> None:
    assert "kind" not in Study(name="a").model_dump()["obstacle"]
    written = Study.model_validate(BARREL).model_dump(mode="json")["obstacle"]
    assert (written["kind"], written["depth"]) == ("side_wall", 3.0)


def test_units_of_other_friction_are_pressed_at_the_side_as_well() -> None:
    varied = {**BARREL, "dataset": {"randomise": {"frictions": [0.3]}}}
    groups = plan_study(Study.model_validate(varied)).designs[0].dataset.perturbed_presses
    assert [press.obstacle.friction for group in groups for press in group] == [0.3, 0.3]
    assert all(press.obstacle.sideways for group in groups for press in group)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"obstacle": {}, "tilts_deg": [0, 2]}, ("obstacle-needs-apex",)),
        ({"designs": {}}, ("side-wall-needs-barrel", "H20 T2")),
        ({"tilts_deg": [70, 92]}, ("side-wall-touches-end", "70", "50")),
        ({"forces": True}, ("skin-no-apex",)),
        ({"built": {}}, ("skin-no-apex",)),
        ({"material": {"gel": "neo-hooke:0.03"}}, ("filling-needs-apex",)),
    ],
)
def test_what_does_not_fit_is_refused_before_anything_is_pressed(
    change: dict[str, object], says: tuple[str, ...]
) -> None:
    with refused(*says):
        plan_study(Study.model_validate({**BARREL, **change}))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"tilts_deg": [0, 2]}, ("greater_than_equal", "60")),
        ({"obstacle": {}}, ("less_than_equal", "30")),
        ({"wall": {"depth": 2}}, ("yaml-key-renamed", "obstacle")),
        ({"side_wall": {"depth": 2}}, ("yaml-key-renamed", "obstacle", "side_wall")),
        ({"obstacle": {"kind": "side_wall", "depth": 100}}, ("less_than_equal", "60")),
        ({"obstacle": {"kind": "side_wall", "dept": 1}}, ("extra_forbidden", "dept")),
        ({"obstacle": {"kind": "side_wall", "tilt_deg": 91}}, ("obstacle-position-given", "tilt_deg")),
        ({"obstacle": {"kind": "ball", "offset": 2}}, ("obstacle-position-given", "offset", "offsets_mm")),
        ({"obstacle": {"kind": "ball"}}, ("positions-of-another-obstacle", "offsets_mm", "tilts_deg")),
        ({"obstacle": {"kind": "pyramid"}}, ("kind-unknown", "pyramid", "ball")),
    ],
)
def test_a_wall_at_the_side_that_is_none_is_refused(change: dict[str, object], says: tuple[str, ...]) -> None:
    with refused(*says):
        Study.model_validate({**BARREL, **change})


def test_a_wrong_number_of_a_wall_at_the_side_is_the_only_error() -> None:
    with refused("extra_forbidden", "dept") as caught:
        Study.model_validate({**BARREL, "obstacle": {"kind": "side_wall", "dept": 1}})
    assert [error["loc"] for error in caught.value.errors()] == [("obstacle", "dept")]


def test_a_wall_at_the_side_needs_tilts_of_its_own() -> None:
    without = {name: value for name, value in BARREL.items() if name != "tilts_deg"}
    with refused("positions-of-another-obstacle", "tilts_deg"):
        Study.model_validate(without)
