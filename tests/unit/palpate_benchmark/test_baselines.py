"""Baselines of the benchmark: what they read, that they beat chance, and that they go on where they were stopped."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from palpate_benchmark import (
    BASELINES,
    PRESETS,
    TINY_BASELINES,
    BenchmarkSet,
    make_benchmark,
    read_predictions,
    read_set,
    run_baselines,
    score_file,
)
from palpate_benchmark import run_baselines as door
from palpate_benchmark.align_to_design import align_to_design, build_dataset, design_rest
from palpate_benchmark.fit_baseline import order_images
from palpate_benchmark.read_set import SplitMarkers
from palpate_benchmark.run_baselines import CHECKSUMS, _Desk

from errors import refused
from needs import needs
from palpate.core import stage_version

TINY = PRESETS["tiny"]
SPEC = TINY.model_copy(update={"designs": TINY.designs[:1], "presses": 30})


class MadeAgainError(Exception):
    """What was there is made again."""


@pytest.fixture(scope="module")
def made_set(tmp_path_factory: pytest.TempPathFactory) -> BenchmarkSet:
    out = tmp_path_factory.mktemp("made")
    make_benchmark(SPEC, out, workers=1)
    return read_set(out / "set")


def test_ridge_and_the_fit_beat_chance_and_each_part_is_made_once(
    made_set: BenchmarkSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = TINY_BASELINES
    first = run_baselines(made_set, spec, tmp_path, ("ridge", "twin"), workers=1)
    chance = made_set.table("test").labels[:, :2].std()
    assert first["ridge"][0].all.parts["angle"].rmse < 0.4 * chance
    assert first["twin"][0].all.parts["angle"].rmse < 0.1 * chance
    assert first["twin"][0].all.parts["force"].rmse < 0.02
    assert [score.track for score in first["ridge"]] == ["markers", "pictures"]
    written = (tmp_path / "ridge.csv").read_bytes()
    assert score_file(made_set, tmp_path / "ridge.csv") == first["ridge"][0]

    def again(*_: object) -> None:
        raise MadeAgainError

    module = __import__("sys").modules[door.__module__]
    monkeypatch.setattr(module, "predict_by_markers", again)
    monkeypatch.setattr(module, "predict_by_fit", again)
    assert run_baselines(made_set, spec, tmp_path, ("ridge", "twin"), workers=1) == first
    assert (tmp_path / "ridge.csv").read_bytes() == written
    with pytest.raises(MadeAgainError):
        run_baselines(made_set, spec.model_copy(update={"jitter_px": 0.5}), tmp_path, ("ridge",))
    assert "ridge" in (tmp_path / "baselines.md").read_text()


def test_networks_and_pictures_are_learnt_and_judged(made_set: BenchmarkSet, tmp_path: Path) -> None:
    for module in ("torch", "onnxruntime"):
        needs(module)
    names = ("paper", "network", "picture")
    found = run_baselines(made_set, TINY_BASELINES, tmp_path, names, workers=1)
    assert tuple(found) == names
    assert [score.track for score in found["picture"]] == ["pictures"]
    pictured = made_set.table("test").picture != ""
    assert (
        read_predictions(tmp_path / "picture.csv").image.tolist() == made_set.table("test").image[pictured].tolist()
    )
    assert all(np.isfinite(score.all.parts["depth"].rmse) for own in found.values() for score in own)


@pytest.mark.parametrize(
    ("stage", "anew"),
    [
        ("baseline", set(BASELINES)),
        ("estimator", {"paper", "network"}),
        ("press", {"twin"}),
        ("twin", {"twin"}),
        ("recorded_estimator", {"picture"}),
    ],
)
def test_a_baseline_is_made_anew_where_a_stage_of_its_own_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stage: str, anew: set[str]
) -> None:
    (tmp_path / CHECKSUMS).write_text("")
    desk = _Desk(SimpleNamespace(folder=tmp_path), TINY_BASELINES, tmp_path, 1, print)  # type: ignore[arg-type]
    before = {name: desk.recipe(name, "all").key for name in BASELINES}

    def changed(name: str) -> str:
        return stage_version(name) + "!" * (name == stage)

    monkeypatch.setattr(sys.modules[door.__module__], "stage_version", changed)
    assert {name for name in BASELINES if desk.recipe(name, "all").key != before[name]} == anew


def test_a_baseline_that_is_none_is_refused(made_set: BenchmarkSet, tmp_path: Path) -> None:
    with refused("baseline-unknown", "luck"):
        run_baselines(made_set, TINY_BASELINES, tmp_path, ("luck",))
    assert len(BASELINES) == 5


def test_registered_images_forget_how_a_camera_is_turned_and_shifted(made_set: BenchmarkSet) -> None:
    design = SPEC.designs[0]
    rest = design_rest(made_set, design)
    found = made_set.markers("train", design.name)
    turn = 1.01 * np.array([[np.cos(0.1), -np.sin(0.1)], [np.sin(0.1), np.cos(0.1)]])
    moved = SplitMarkers(
        found.image,
        found.unit,
        found.markers_px @ turn + [3.0, -2.0],
        {unit: seen @ turn + [3.0, -2.0] for unit, seen in found.rest_px.items()},
    )
    assert np.allclose(align_to_design(moved, rest), align_to_design(found, rest), atol=1e-9)


def test_a_dot_that_is_missing_moves_as_its_neighbours() -> None:
    rest = np.array([(x, y) for x in range(0, 50, 10) for y in range(0, 50, 10)], float)
    seen = rest + np.array([2.0, -1.0])
    seen[12] = np.nan
    printed = rest.copy()
    printed[12] = np.nan
    found = SplitMarkers(np.array([0]), np.array([1]), seen[None], {1: printed})
    assert np.allclose(align_to_design(found, rest)[0], rest + np.array([2.0, -1.0]))


def test_units_that_calibrate_teach_nothing(made_set: BenchmarkSet) -> None:
    dataset = build_dataset(made_set, SPEC.designs[0], 0.1)
    table = made_set.table("calibrate")
    assert set(dataset.press[dataset.validation]) == set(table.press)
    assert np.array_equal(dataset.poses[dataset.validation], table.labels[:, :3])


def test_images_are_fitted_each_once_and_near_the_last(made_set: BenchmarkSet) -> None:
    found = made_set.markers("test", SPEC.designs[0].name)
    order = order_images(found, SPEC.units)
    assert sorted(order) == np.flatnonzero(found.unit == SPEC.units).tolist()
    moved = np.nan_to_num(found.markers_px)
    steps = np.abs(np.diff(moved[order], axis=0)).mean()
    assert steps < 0.7 * np.abs(np.diff(moved[np.sort(order)], axis=0)).mean()
