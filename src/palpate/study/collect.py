"""From the artefacts of designs to their records."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import ArtefactStore, provenance
from palpate.dataset import DATASET_VERSION
from palpate.design import build_dome
from palpate.fea import FEA_VERSION, read_press
from palpate.learn import LEARN_VERSION, Metrics
from palpate.study.result import Counts, DesignResult, PressSummary
from palpate.study.task import LearningTask, Task
from palpate.study.worker import Outcome


def collect_designs(
    tasks: Sequence[LearningTask], store: ArtefactStore, outcomes: Mapping[str, Outcome], seed: int
) -> tuple[DesignResult, ...]:
    """Collect the records of designs from the store; a press that serves several is read once.

    Parameters
    ----------
    tasks
        The last task of each design.
    store
        Where the artefacts are.
    outcomes
        How the tasks of this run ended, by key.
    seed
        Seed of the study.
    """
    recipes = {press.recipe.key: press.recipe for task in tasks for press in task.dataset.presses}
    paths = {key: store.find(recipe) for key, recipe in recipes.items()}
    presses = {key: _summarise_press(path) for key, path in paths.items() if path is not None}
    versions = {**provenance(), "fea": FEA_VERSION, "dataset": DATASET_VERSION, "learn": LEARN_VERSION}
    return tuple(
        _collect_design(task, _read_tally(store.find(task.recipe, task.suffix)), outcomes, presses, seed, versions)
        for task in tasks
    )


def _collect_design(
    task: LearningTask,
    tally: dict[str, Any],
    outcomes: Mapping[str, Outcome],
    presses: Mapping[str, PressSummary],
    seed: int,
    versions: Mapping[str, str],
) -> DesignResult:
    dataset = task.dataset
    keys = tuple(press.recipe.key for press in dataset.presses)
    summaries = tuple(presses[key] for key in keys if key in presses)
    failed: tuple[Task, ...] = (task, dataset, *dataset.presses)
    reasons = [outcomes[item.recipe.key].reason for item in failed if item.recipe.key in outcomes]
    return DesignResult(
        dome=dataset.dome,
        markers=dataset.markers,
        shape=build_dome(dataset.dome).shape,
        clean=Metrics.from_dict(tally["clean"]) if tally else None,
        jittered=Metrics.from_dict(tally["jittered"]) if tally else None,
        travel_mm=float(tally["travel_mm"]) if tally else float("nan"),
        force_n=summaries[0].force_n if summaries else float("nan"),
        peak_stress_mpa=max((press.peak_stress_mpa for press in summaries), default=float("nan")),
        presses=summaries,
        counts=Counts(**tally["counts"]) if tally else None,
        seed=seed,
        versions=versions,
        artefacts={
            "press": keys,
            "dataset": (dataset.recipe.key,),
            "learning": (task.recipe.key,),
        },
        failure="" if tally else next((reason for reason in reasons if reason), "it was not computed"),
    )


def _summarise_press(path: Path) -> PressSummary:
    press = read_press(path)
    return PressSummary(
        tilt_deg=press.wall.tilt_deg,
        ended=str(press.ended),
        ended_depth_mm=float(press.ended_depth),
        force_n=float(np.linalg.norm(press.force[-1])),
        peak_stress_mpa=float(np.max(press.peak_stress)),
        branch=str(press.branch[-1]),
    )


def _read_tally(path: Path | None) -> dict[str, Any]:
    if path is None:
        return {}
    content: dict[str, Any] = json.loads(path.read_text())
    return content
