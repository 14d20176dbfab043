from dataclasses import replace
from pathlib import Path

import pytest

from errors import refused
from palpate.core.run import Outcome
from palpate.study import Study, plan_twin, read_study
from palpate.study.plan import plan_study
from palpate.study.schedule import Schedule
from palpate.study.study import AsBuiltSpec, MaterialSpec
from palpate.study.task import PressTask

AFTER_PRESS = {"dataset", "limit", "estimator", "learning"}


def plan_of(**choices: object) -> dict[str, str]:
    """Key of every task by its name."""
    study = Study.model_validate({"name": "a", "tilts_deg": [0, 2], **choices})
    return {task.name: task.recipe.key for task in plan_study(study).tasks()}


def kinds_changed(**choices: object) -> set[str]:
    before, after = plan_of(), plan_of(**choices)
    return {name.split()[0] for name in before if before[name] != after[name]}


def test_first_shares_its_presses_between_layouts() -> None:
    kinds = [task.recipe.kind for task in plan_study(read_study("first")).tasks()]
    counts = {kind: kinds.count(kind) for kind in kinds}
    assert counts == {
        **{"press": 14 + 2 * 3, "inverted": 2, "twin": 2},
        **dict.fromkeys(("dataset", "limit", "estimator", "learning", "built"), 8),
    }


def test_limits_need_presses_and_nothing_else() -> None:
    kinds = [task.recipe.kind for task in plan_study(read_study("first")).bound_tasks()]
    assert {kind: kinds.count(kind) for kind in kinds} == {"press": 14, "limit": 8}


def test_paper_needs_84_presses_for_48_designs_and_36_for_the_prediction() -> None:
    kinds = [task.recipe.kind for task in plan_study(read_study("paper")).tasks()]
    assert (kinds.count("press"), kinds.count("learning")) == (84 + 36, 48)
    unpredicted = plan_study(read_study("paper").model_copy(update={"built": None})).tasks()
    assert [task.recipe.kind for task in unpredicted].count("press") == 84


def test_a_prediction_adds_derivatives_to_presses_of_the_study() -> None:
    plan = plan_study(Study(name="a"))
    predicted, own = plan.built[0].twin.presses, plan.designs[0].dataset.presses
    shared = [press.obstacle.radial for press in own if press in predicted]
    assert shared == [press.obstacle.radial for press in own if press.solver.derivatives] == [0.0, 8.0, 12.0]
    sloped = {press.obstacle.contact for press in predicted if "friction" in press.solver.derivatives}
    assert sloped == {press.obstacle.contact for press in predicted} - {"no-slip"} != set()
    assert min(map(float, sloped)) <= AsBuiltSpec().tolerance.friction_at(0.0), "no friction is drawn beyond the twin"
    assert [
        len(plan_study(Study(name="a", tilts_deg=tilts)).tasks()) for tilts in ((0, 4), (0, 4, 8), (2, 4, 8))
    ] == [*(2 + 5, 3 + 3 + 7, 3 + 5)]


def test_every_task_comes_after_those_it_needs() -> None:
    seen: set[str] = set()
    for task in plan_study(read_study("first")).tasks():
        assert {need.recipe.key for need in task.dependencies} <= seen
        seen.add(task.recipe.key)


def test_the_same_study_has_the_same_keys() -> None:
    assert plan_of() == plan_of()


@pytest.mark.parametrize(
    ("choices", "changed"),
    [
        ({"obstacle": {"depth": 7.0}}, {"press", *AFTER_PRESS}),
        ({"material": {"bulk_ratio": 20}}, {"press", *AFTER_PRESS}),
        ({"camera": {"distance": 50}}, AFTER_PRESS),
        ({"dataset": {"jitter_px": 1.0}}, AFTER_PRESS),
        ({"seed": 1}, AFTER_PRESS),
        ({"learning": {"seed": 1}}, {"estimator", "learning"}),
        ({"learning": {"preset": "best"}}, {"estimator", "learning"}),
        ({"name": "b"}, set()),
    ],
)
def test_a_choice_changes_only_what_hangs_on_it(choices: dict[str, object], changed: set[str]) -> None:
    assert kinds_changed(**choices) == changed


def test_the_content_of_a_layout_file_changes_the_dataset(tmp_path: Path) -> None:
    dots = tmp_path / "dots.csv"
    keys = []
    for x in (1, 2):
        dots.write_text(f"x_mm,y_mm\n{x},0\n5,5\n")
        keys.append(plan_of(designs={"markers": [{"file": str(dots)}]}))
    assert [name for name in keys[0] if keys[0][name] != keys[1][name]] == [
        "dataset H20 T2 2 markers",
        "limit H20 T2 2 markers",
        "estimator H20 T2 2 markers",
        "learning H20 T2 2 markers",
    ]


def test_networks_tell_forces_where_a_study_asks_and_nothing_else_changes() -> None:
    study = Study(name="a")
    plain, told = plan_study(study), plan_study(study.model_copy(update={"forces": True}))
    keys = [{task.recipe.key for task in plan.tasks()} for plan in (plain, told)]
    assert keys[0] < keys[1]
    assert {task.recipe.key for task in told.forces} == keys[1] - keys[0]
    assert plain.forces == ()


def test_a_design_that_cannot_be_built_is_named() -> None:
    with refused("ring-outside-dome", "H20 T2", "12", "25"):
        plan_of(designs={"markers": [{"ring_diameters": [10, 50]}]})


def test_units_that_differ_are_pressed_for_the_dataset_alone() -> None:
    plain = plan_of()
    varied = plan_of(dataset={"randomise": {"frictions": [0.7, 1.2], "thickness": 0.05}})
    presses = {name for name in varied if name.startswith("press") and "inverted" not in name}
    assert {
        name: key for name, key in varied.items() if name in plain and name.startswith(("press", "inverted"))
    } == {name: key for name, key in plain.items() if name.startswith(("press", "inverted"))}
    assert len(presses) == 2 * (1 + 2 + 2)
    assert {"press H20 T2 tilt 2° friction 0.7", "press H20 T1.95 tilt 0°"} <= presses
    assert kinds_changed(dataset={"randomise": {"thickness": 0.05}}) == AFTER_PRESS
    assert kinds_changed(dataset={"randomise": None}) == set()


@pytest.mark.parametrize("preset", ["quick", "best"])
def test_inverted_states_do_not_wait_for_the_trainings(preset: str) -> None:
    """One may take as long as five trainings: begun last, it would keep the whole study waiting."""
    study = Study.model_validate({"name": "a", "learning": {"preset": preset}})
    schedule, kinds = Schedule(plan_study(study).tasks(), []), []
    while (task := schedule.next_task()) is not None:
        kinds.append(task.recipe.kind)
        list(schedule.complete(task, Outcome()))
    assert kinds.index("estimator") > max(at for at, kind in enumerate(kinds) if kind == "inverted")


def test_a_filled_skin_is_pressed_filled_and_in_one_state() -> None:
    gel = Study(name="gel", material={"gel": "neo-hooke:0.001"}, designs={"heights": [20], "thicknesses": [1]})
    tasks = plan_study(gel).tasks()
    presses = [task for task in tasks if isinstance(task, PressTask)]
    assert len(presses) == len(gel.tilts_deg) + 3
    assert all(press.mesh.filled and press.design.material.gel is not None for press in presses)
    hollow = plan_study(gel.model_copy(update={"material": MaterialSpec()}))
    assert len([task for task in hollow.tasks() if isinstance(task, PressTask)]) == len(presses) + 1
    with refused("material-unknown"):
        Study(name="gel", material={"gel": "honey"})


def test_a_pad_is_pressed_at_every_azimuth_of_a_tilt_whole_where_half_would_not_do() -> None:
    pad = {"kind": "pad", "flat_radius": 7.5, "edge_radius": 2.0}
    designs = {"skin": pad, "heights": [3.5], "thicknesses": [0.5], "base_radius": 10.4}
    study = Study.model_validate({"name": "a", "tilts_deg": [0, 2], "designs": designs})
    presses = plan_study(study).designs[0].dataset.presses
    assert [(task.obstacle.tilt_deg, task.obstacle.azimuth_deg, task.mesh.whole) for task in presses] == [
        (0.0, 0.0, False),
        (2.0, 0.0, False),
        (2.0, 30.0, True),
        (2.0, 60.0, True),
        (2.0, 90.0, True),
    ]
    assert presses[2].name.endswith("tilt 2° azimuth 30°")
    coarse = study.model_copy(update={"azimuths_deg": (0.0, 90.0)})
    assert len(plan_study(coarse).designs[0].dataset.presses) == 3
    with refused("forces-need-revolution"):
        plan_study(study.model_copy(update={"forces": True}))
    with refused("twin-needs-revolution"):
        plan_study(study.model_copy(update={"built": AsBuiltSpec()}))
    with refused("study-needs-flat-wall", "ball"):
        plan_study(
            Study.model_validate(
                {"name": "a", "offsets_mm": [0, 1], "designs": designs, "obstacle": {"kind": "ball"}}
            )
        )


def test_a_study_of_usual_azimuths_is_written_as_before_there_were_any() -> None:
    assert "azimuths_deg" not in Study(name="a").model_dump(mode="json")
    assert Study(name="a", azimuths_deg=(0, 45, 90)).model_dump()["azimuths_deg"] == (0, 45, 90)
    with refused("azimuths-uneven"):
        Study(name="a", azimuths_deg=(0, 30, 90))


def test_a_twin_that_reads_images_has_all_frictions_and_half_the_depth_step() -> None:
    study = Study(name="a")
    twin = plan_twin(study, study.designs.skins()[0])
    assert {press.obstacle.radial for press in twin.presses} == {0.0, 4.0, 8.0, 12.0}
    assert len(twin.presses) == 4 * 5
    assert {press.obstacle.depth_step for press in twin.presses} == {0.5 * study.obstacle.depth_step}
    assert {check.obstacle.depth_step for check in twin.checks} == {0.75 * study.obstacle.depth_step}
    fine = plan_twin(study.model_copy(update={"tilts_deg": (0.0, 1.0, 2.0, 3.0)}), study.designs.skins()[0])
    assert {press.obstacle.radial for press in fine.presses} == {0.0, 1.0, 2.0, 3.0}


def test_a_prediction_leaves_the_images_of_a_study_as_they_are() -> None:
    shallow = Study.model_validate({"name": "a", "obstacle": {"depth": 3.0}})
    assert {press.obstacle.depth_step for press in plan_study(shallow).designs[0].dataset.presses} == {0.8}
    assert {press.obstacle.depth_step for press in plan_study(shallow).built[0].twin.presses} == {0.375}


@pytest.mark.parametrize(("depth", "step"), [(8.0, 0.4), (6.0, 0.4), (3.0, 0.375), (9.0, 9.0 / 23)])
def test_the_steps_of_a_twin_are_equal_and_reach_its_depth(depth: float, step: float) -> None:
    study = Study.model_validate({"name": "a", "obstacle": {"depth": depth}})
    twin = plan_twin(study, study.designs.skins()[0])
    assert {press.obstacle.depth_step for press in twin.presses} == {step}


def test_a_whole_mesh_costs_twice_a_half_and_a_filled_skin_ten_times_a_hollow_one() -> None:
    (task, *_) = plan_study(Study(name="a")).designs[0].dataset.presses
    half, whole, filled = (
        replace(task, mesh=task.mesh.model_copy(update=change)).cost
        for change in ({"whole": False}, {"whole": True}, {"filled": True})
    )
    assert [whole / half, filled / half] == pytest.approx([2.0, 10.0])


@pytest.mark.parametrize("checks", [1, 2, 3])
def test_validation_presses_lie_between_the_tilts_and_the_slips_of_the_twin(checks: int) -> None:
    study = Study.model_validate(
        {
            "name": "a",
            "tilts_deg": (0.0, 4.0, 8.0, 12.0),
            "built": {"contacts": ("no-slip", 2.0, 0.5), "checks": checks, "inverted": False},
        }
    )
    twin = plan_twin(study, study.designs.skins()[0])
    walls = [check.obstacle for check in twin.checks]
    assert len(walls) == checks
    tilts = {1: [6.0], 2: [2.0, 10.0], 3: [2.0, 6.0, 10.0]}[checks]
    slips = {1: [1.25], 2: [0.25, 1.25], 3: [0.25, 1.25, 1.25]}[checks]
    assert [wall.tilt_deg for wall in walls] == pytest.approx(tilts)
    assert [1 / float(wall.contact) for wall in walls] == pytest.approx(slips, rel=1e-5)
    assert len({wall.azimuth_deg for wall in walls} - {0.0}) == checks
    assert all(not task.solver.derivatives for task in twin.checks)
    assert len(twin.presses) == 4 * 3
    assert {task.obstacle.tilt_deg for task in twin.presses} == {0.0, 4.0, 8.0, 12.0}
    assert {task.obstacle.contact for task in twin.presses} == {"no-slip", 2.0, 0.5}


@pytest.mark.parametrize(
    ("tilts", "step_deg", "kept"),
    [
        ((0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0), 4.0, (0.0, 4.0, 8.0, 12.0)),
        ((0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0), 0.0, (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0)),
        ((0.0, 2.0, 4.0, 6.0), 4.0, (0.0, 2.0, 4.0, 6.0)),
        ((0.0, 3.0, 5.0, 6.0, 9.0, 11.0, 12.0), 4.0, (0.0, 3.0, 6.0, 9.0, 12.0)),
    ],
)
def test_tilts_of_a_twin_are_as_far_apart_as_they_may(tilts: tuple, step_deg: float, kept: tuple) -> None:
    built = {"tilt_step_deg": step_deg, "contacts": ("no-slip",), "inverted": False, "checks": 0}
    study = Study.model_validate({"name": "a", "tilts_deg": tilts, "built": built})
    twin = plan_twin(study, study.designs.skins()[0])
    assert tuple(task.obstacle.tilt_deg for task in twin.presses) == kept
