import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.core import ArtefactStore
from palpate.core.run import Progress, run_call
from palpate.datasets import Dataset, DatasetSpec, sample_poses, write_dataset
from palpate.learn import ErrorBound, TrainingSpec, calibrate_interval, fit_ridge, write_estimator
from palpate.study import Study
from palpate.study.collect import collect_designs
from palpate.study.plan import Plan, plan_study
from palpate.study.schedule import run_task
from palpate.study.task import EvaluationTask


def make_dataset(markers: int = 7, presses: int = 200) -> Dataset:
    """Images that are a linear map of the pose, at one depth, so that ridge regression is nearly exact."""
    spec = DatasetSpec(n_presses=presses, jitter_px=0.5)
    poses = np.column_stack([sample_poses(spec), np.full(presses, 4.0)])
    rest = np.random.default_rng(0).uniform(100, 200, (markers, 2))
    moved = poses[:, :2] @ np.random.default_rng(1).normal(0, 3.0, (2, 2 * markers))
    return Dataset(
        spec=spec,
        images_px=rest + moved.reshape(presses, markers, 2),
        poses=poses,
        press=np.arange(presses),
        validation=np.arange(presses) % 2 == 0,
        branch=np.full(presses, "flat"),
        travel_mm=np.full(presses, 1.0),
        rest_px=rest,
        image_size_px=(346, 260),
        solved_presses=1,
        dropped={},
    )


def prepare(store: ArtefactStore, floor_deg: float) -> EvaluationTask:
    """A learning task whose inputs lie in the store, judged against a floor of this height."""
    study = Study.model_validate({"name": "a", "tilts_deg": [0], "designs": {"markers": [7]}})
    (task,) = plan_study(study).designs
    dataset = make_dataset()
    estimator = calibrate_interval(fit_ridge(dataset), dataset)
    limit = ErrorBound(4.0, 48, 1.0, 2 * floor_deg, 0.1, floor_deg, 0.001, floor_deg, 0.001)
    store.write(task.dataset.recipe, lambda path: write_dataset(path, dataset))
    store.write(task.estimator.recipe, lambda path: write_estimator(path, estimator), ".onnx")
    store.write(task.bound.recipe, lambda path: _write(path, [asdict(limit)]), ".json")
    return task


def _write(path: Path, content: object) -> None:
    path.write_text(json.dumps(content))


def test_a_network_of_other_training_is_another_artefact(monkeypatch: pytest.MonkeyPatch) -> None:
    study = Study.model_validate({"name": "a", "tilts_deg": [0], "designs": {"markers": [7]}})
    (first,) = plan_study(study).designs
    before, other = first.estimator.recipe.key, TrainingSpec(epochs=61)
    monkeypatch.setattr("palpate.study.task.TrainingSpec", lambda: other)
    (after,) = plan_study(study).designs
    assert after.estimator.recipe.key != before


def test_an_honest_estimator_is_judged(tmp_path: Path) -> None:
    store = ArtefactStore(tmp_path)
    task = prepare(store, floor_deg=0.01)
    task.make(store)
    (design,) = collect_designs(Plan((task,), (None,)), store, {}, seed=0)
    assert design.clean is not None
    assert design.clean.rmse_deg < 0.1
    assert design.bounds[0].floor_deg == 0.01
    assert design.coverage is not None
    assert (design.coverage.level, design.coverage.presses) == (0.9, 50)
    assert 0.8 < design.coverage.angle < 1.0
    assert set(design.artefacts) == {"press", "dataset", "limit", "estimator", "learning"}
    assert design.spec["dataset"]["seed"] == task.dataset.spec.seed
    assert design.spec["tilts_deg"] == [0.0]


def test_an_estimator_better_than_any_can_be_is_refused_as_leakage(tmp_path: Path) -> None:
    store = ArtefactStore(tmp_path)
    task = prepare(store, floor_deg=3.0)
    with refused("evaluation-leaks", "4", "3"):
        task.make(store)
    assert store.find(task.recipe, task.suffix) is None


def test_the_design_of_a_leak_fails_with_its_reason_and_keeps_its_limit(tmp_path: Path) -> None:
    store = ArtefactStore(tmp_path)
    task = prepare(store, floor_deg=3.0)
    (design,) = collect_designs(
        Plan((task,), (None,)), store, {task.recipe.key: run_call(run_task, (task, store), Progress())}, seed=0
    )
    assert design.failure.startswith("Leakage")
    assert design.clean is design.jittered is None
    assert design.bounds[0].least_squares_deg == 6.0
