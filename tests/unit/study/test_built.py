"""Built units in a study: twins and figures as tasks, and where a person reads them."""

from pathlib import Path

import pytest

from palpate.core import ArtefactStore
from palpate.study import Study, evaluate_grid, ranking_column, run_tasks, run_twins
from palpate.study.collect import collect_designs
from palpate.study.plan import plan_study

SMALL = {
    "name": "small",
    "tilts_deg": [0, 4, 8, 12],
    "designs": {"markers": [7, 37]},
    "mesh": {"cells": 6},
    "obstacle": {"contact": "frictionless", "depth": 3.2},
}
STUDY = Study.model_validate(SMALL | {"built": {"calibration_presses": 3, "tolerance": {"thickness": 0.1}}})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("built")


def test_built_units_are_foreseen_without_training(folder: Path) -> None:
    few, many = run_twins(STUDY, folder, workers=1)
    assert few.problem == many.problem == ""
    assert few.twin == many.twin
    assert [figure.calibration_presses for figure in many.accuracies] == [0, 3]
    assert many.accuracies[1].rmse_deg < many.accuracies[0].rmse_deg < few.accuracies[0].rmse_deg
    assert many.accuracies[0].rmse_deg < many.accuracies[0].p95_deg < 2.0


def test_a_study_that_gives_built_is_predicted_by_the_twin_that_reads_images(folder: Path) -> None:
    found = run_twins(STUDY, folder, workers=1)
    grid = evaluate_grid(collect_designs(plan_study(STUDY), ArtefactStore(folder / "store"), {}, seed=0))
    assert [row["built_rmse_deg"] for row in grid.designs] == [design.accuracies[0].rmse_deg for design in found]


def test_few_presses_predict_the_accuracy_in_the_first_columns_and_pictures_of_a_grid(folder: Path) -> None:
    study = Study.model_validate(SMALL)
    found, plan = run_twins(study, folder, workers=1), plan_study(study)
    assert run_tasks(folder, [task for task in plan.built if task], workers=1) == {}
    grid = evaluate_grid(collect_designs(plan, ArtefactStore(folder / "store"), {}, seed=0))
    assert len(plan.built[0].twin.presses) == 3  # without friction
    for column, known in (("built", 0), ("calibrated", 1)):
        for figure, wide in (("rmse_deg", 0.03), ("p95_deg", 0.04)):
            expected = [getattr(design.accuracies[known], figure) for design in found]
            assert [row[f"{column}_{figure}"] for row in grid.designs] == pytest.approx(expected, rel=wide)
    assert grid.columns.index("calibrated_p95_deg") < grid.columns.index("rmse_deg")
    assert ranking_column(grid.columns) == "built_rmse_deg"


def test_a_study_without_a_prediction_has_no_such_columns() -> None:
    plan = plan_study(STUDY.model_copy(update={"built": None}))
    assert plan.built == (None, None)
    assert not any(task.recipe.kind in ("twin", "built") for task in plan.tasks())


def test_other_tolerances_are_other_figures_of_the_same_twin() -> None:
    plan, other = (plan_study(STUDY.model_copy(update={"built": built})) for built in (STUDY.built, _wider()))
    assert plan.built[0].twin.recipe.key == other.built[0].twin.recipe.key
    assert plan.built[0].recipe.key != other.built[0].recipe.key


def _wider():
    assert STUDY.built is not None
    return STUDY.built.model_copy(update={"tolerance": STUDY.built.tolerance.model_copy(update={"print_shift": 0.5})})
