"""Run and comparison of the five baselines; each is stored under its recipe."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from palpate.core import ArtefactStore, PalpateError, Recipe, stage_version
from palpate.core.run import Progress
from palpate.sensor import write_report
from palpate.study import find_artefact, run_tasks
from palpate.surrogate import read_twin
from palpate_benchmark.fit_baseline import predict_by_fit
from palpate_benchmark.predictions import Predictions, read_predictions, write_predictions
from palpate_benchmark.read_set import BenchmarkSet
from palpate_benchmark.score import BenchmarkScore, score_predictions, select_track
from palpate_benchmark.score_page import SCORE_COLUMNS, compare_report, score_rows
from palpate_benchmark.set_files import CHECKSUMS, digest
from palpate_benchmark.spec import BaselineSpec
from palpate_benchmark.trained_baselines import LEARNERS, predict_by_images, predict_by_markers
from palpate_benchmark.unit_task import plan_design_twin

BASELINES = {
    "ridge": "ridge regression on markers",
    "paper": "the paper's perceptron on markers",
    "network": "palpate's network on markers",
    "twin": "fit of a twin",
    "picture": "network on images",
}
"""Labels of the baselines, by name."""
_STAGES = {
    "paper": ("estimator",),
    "network": ("estimator",),
    "twin": ("press", "twin"),
    "picture": ("recorded_estimator",),
}
"""Stages that determine the predictions of each, in addition to `baseline`."""


@dataclass(frozen=True, eq=False)
class _Desk:
    """Inputs of the baselines."""

    benchmark: BenchmarkSet
    spec: BaselineSpec
    out: Path
    workers: int | None
    progress: Progress

    @property
    def store(self) -> ArtefactStore:
        return ArtefactStore(self.out / "store")

    def recipe(self, name: str, part: str) -> Recipe:
        fields = {"ridge": {"jitter_px"}, "paper": {"paper", "seed", "jitter_px"}, "twin": {"twin"}}
        fields |= {"network": {"network", "seed", "jitter_px"}, "picture": {"seed", "picture_px", "picture_epochs"}}
        chosen = self.spec.model_dump(mode="json", include=fields[name])
        chosen |= {"interval": "by press"} if name == "picture" else {}  # by image before 0.3
        about = digest(self.benchmark.folder / CHECKSUMS)
        version = "; ".join(map(stage_version, ("baseline", *_STAGES.get(name, ()))))
        return Recipe("baseline", {"name": name, "part": part, "spec": chosen}, (about,), version)


def run_baselines(
    benchmark: BenchmarkSet,
    spec: BaselineSpec,
    out: Path,
    only: Sequence[str] = (),
    workers: int | None = None,
    progress: Progress | None = None,
) -> dict[str, list[BenchmarkScore]]:
    """Make predictions ``out/NAME.csv`` and the tables ``out/baselines.md``, ``.csv`` and ``.json``.

    Results of an earlier run in ``out/store`` are reused.

    Parameters
    ----------
    benchmark
        Data set with its hidden labels, which give the scores.
    spec
        Settings of the baselines.
    out
        Result folder.
    only
        Names of `BASELINES`; empty: all.
    workers
        Processes that solve the presses of twins; `None`: one per core.
    progress
        Receives each unit, each epoch and each baseline.

    Returns
    -------
    dict[str, list[BenchmarkScore]]
        Score of each track, by name.

    Raises
    ------
    PalpateError
        If a name is unknown, the data set is damaged, or files cannot be written.
    """
    unknown = [name for name in only if name not in BASELINES]
    if unknown:
        raise PalpateError(
            f"Unknown baseline '{unknown[0]}'.", f"Choose from {', '.join(BASELINES)}.", code="baseline-unknown"
        )
    desk = _Desk(benchmark, spec, out, workers, progress or Progress())
    scores: dict[str, list[BenchmarkScore]] = {}
    for name in [name for name in BASELINES if not only or name in only]:
        started = time.process_time()
        found = _make(desk, name)
        write_predictions(out / f"{name}.csv", found)
        scores[name] = _score(benchmark, found, name)
        desk.progress.note(
            f"{name}: {scores[name][0].all.parts['angle'].rmse:.3f}°, {time.process_time() - started:.0f} CPU s"
        )
        _write(out, scores)
    return scores


def _make(desk: _Desk, name: str) -> Predictions:
    """Make the predictions of all designs; parts in the store are reused."""
    designs = {design.name: design for design in desk.benchmark.spec.designs}
    parts = ["all"] if name == "picture" else list(designs)
    found = []
    for part in parts:
        recipe = desk.recipe(name, part)
        path = desk.store.find(recipe, ".csv")
        if path is None:
            if name == "picture":
                kept = desk.store.path(recipe, ".kept")
                kept.parent.mkdir(parents=True, exist_ok=True)
                made = predict_by_images(desk.benchmark, desk.spec, kept, desk.progress)
                kept.unlink(missing_ok=True)
            elif name in LEARNERS:
                made = predict_by_markers(name, desk.benchmark, designs[part], desk.spec)
            else:
                made = _fit(desk, part)
            path = desk.store.write(recipe, partial(_put, made), ".csv")
            desk.progress.note(f"{name}: {part} done")
        found.append(read_predictions(path))
    names = found[0].values
    joined = {column: np.concatenate([each.values[column] for each in found]) for column in names}
    return Predictions(np.concatenate([each.image for each in found]), joined)


def _put(made: Predictions, path: Path) -> None:
    write_predictions(path, made)


def _fit(desk: _Desk, part: str) -> Predictions:
    design = next(design for design in desk.benchmark.spec.designs if design.name == part)
    task = plan_design_twin(desk.benchmark.spec, design, desk.spec.twin)
    failed = run_tasks(desk.out, [task], desk.workers, desk.progress)
    if failed:
        raise PalpateError(
            f"The twin of {part} could not be made: {next(iter(failed.values()))}",
            "Change the presses of the twin in the settings of the baselines.",
            code="twin-not-made",
        )
    return predict_by_fit(desk.benchmark, design, read_twin(find_artefact(desk.store, task)), desk.progress)


def _score(benchmark: BenchmarkSet, found: Predictions, name: str) -> list[BenchmarkScore]:
    scores = [] if name == "picture" else [score_predictions(benchmark, found)]
    if not benchmark.spec.pictures:
        return scores
    pictured = select_track(benchmark.table("test"), "pictures").image
    rows = np.isin(found.image, pictured)
    chosen = Predictions(found.image[rows], {column: values[rows] for column, values in found.values.items()})
    return [*scores, score_predictions(benchmark, chosen, "pictures")]


def _write(out: Path, scores: dict[str, list[BenchmarkScore]]) -> None:
    table = compare_report({BASELINES[name]: own for name, own in scores.items()})
    rows = [[name, score.track, *row] for name, own in scores.items() for score in own for row in score_rows(score)]
    plain = {name: [score.as_dict() for score in own] for name, own in scores.items()}
    write_report(out, "baselines", plain, ["# Baselines", table], [["method", "track", *SCORE_COLUMNS], *rows])
