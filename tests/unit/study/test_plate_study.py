"""Studies of plates with a hole, as the obstacle and as a variation of it."""

import pytest

from errors import refused
from palpate.study import Study, plan_study

STUDY = {"name": "holes", "tilts_deg": [0, 6], "obstacle": {"kind": "plate", "hole_diameter": 4.0, "depth": 2.4}}


def varied(**study: object) -> Study:
    return Study.model_validate({"name": "varied", "tilts_deg": [0, 6], **study})


def test_a_plate_is_pressed_at_the_tilts_of_the_study() -> None:
    presses = plan_study(Study.model_validate(STUDY)).designs[0].dataset.presses
    assert [(press.obstacle.kind, press.obstacle.radial, press.obstacle.depth) for press in presses] == [
        ("plate", 0.0, 2.4),
        ("plate", 6.0, 2.4),
    ]


def test_a_plate_has_the_tilts_of_a_wall_by_default() -> None:
    assert Study.model_validate({**STUDY, "tilts_deg": Study.model_fields["tilts_deg"].default}) == (
        Study.model_validate({key: value for key, value in STUDY.items() if key != "tilts_deg"})
    )


def test_every_further_obstacle_is_pressed_with_the_travel_of_the_study() -> None:
    holes = [{"kind": "plate", "hole_diameter": 3.0}, {"kind": "plate", "hole_diameter": 9.0, "offset": -2.0}]
    study = varied(
        obstacle={"depth": 3.2, "contact": 0.5},
        dataset={"randomise": {"frictions": [0.3], "thickness": 0.1, "obstacles": holes}},
    )
    groups = plan_study(study).designs[0].dataset.perturbed_presses
    assert [len(group) for group in groups] == [2] * 5
    found = [[press.obstacle for press in group] for group in groups[3:]]
    assert [[one.hole_diameter for one in group] for group in found] == [[3.0, 3.0], [9.0, 9.0]]
    assert {(one.depth, one.friction) for group in found for one in group} == {(3.2, 0.5)}
    assert [one.radial for one in found[1]] == [0.0, 6.0]


@pytest.mark.parametrize("obstacle", [{**STUDY["obstacle"], "offset_across": 1.0}, {"twist_rate_deg": 1.0}])
def test_an_obstacle_that_is_not_mirrored_presses_a_whole_mesh(obstacle: dict[str, object]) -> None:
    presses = plan_study(varied(obstacle=obstacle)).designs[0].dataset.presses
    assert all(press.mesh.whole for press in presses)


def test_three_steps_leave_one_image() -> None:
    assert plan_study(varied(obstacle={"depth": 2.4, "depth_step": 0.8})).designs


@pytest.mark.parametrize(
    ("study", "code"),
    [
        ({"dataset": {"randomise": {"obstacles": [{"kind": "ball"}]}}}, "obstacle-pose-differs"),
        ({"obstacle": {"depth": 2.3, "depth_step": 0.8}}, "dataset-no-image"),
        ({"dataset": {"randomise": {"obstacles": [{"kind": "plate", "hole_diameter": 60}]}}}, "obstacle-misses-skin"),
    ],
)
def test_unsuitable_obstacles_are_refused_before_a_press(study: dict[str, object], code: str) -> None:
    with refused(code):
        plan_study(varied(**study))
