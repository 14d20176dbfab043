"""Records of designs, collected from their artefacts."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import ArtefactStore, provenance, stage_version
from palpate.core.run import Outcome
from palpate.design import Symmetry
from palpate.fea import Branch, read_press
from palpate.learn import Coverage, Metrics
from palpate.study.accuracy_task import AccuracyTask, read_accuracy
from palpate.study.force_task import ForceTask
from palpate.study.plan import Plan
from palpate.study.result import Counts, DesignBounds, DesignResult, PressSummary
from palpate.study.study import positions_field
from palpate.study.task import BoundTask, DatasetTask, EvaluationTask, Task, read_bounds


def collect_designs(
    plan: Plan, store: ArtefactStore, outcomes: Mapping[str, Outcome], seed: int
) -> tuple[DesignResult, ...]:
    """Collect the records of designs from the store; a shared press is read once.

    Parameters
    ----------
    plan
        The tasks of the study.
    store
        Store of the artefacts.
    outcomes
        Outcomes of the tasks of this run, by key.
    seed
        Seed of the study.
    """
    tasks = plan.designs
    recipes = {press.recipe.key: press.recipe for task in tasks for press in task.dataset.presses}
    paths = {key: store.find(recipe) for key, recipe in recipes.items()}
    presses = {key: _summarise_press(path) for key, path in paths.items() if path is not None}
    known = _Known(store, outcomes, presses, _versions(), seed)
    forces = plan.forces or (None,) * len(tasks)
    return tuple(_collect_design(*design, known) for design in zip(tasks, plan.built, forces, strict=True))


def collect_bounds(
    tasks: Sequence[BoundTask], store: ArtefactStore, outcomes: Mapping[str, Outcome]
) -> tuple[DesignBounds, ...]:
    """Collect the bounds of designs from the store; `outcomes` are those of this run's tasks, by key."""
    found = []
    for task in tasks:
        path = store.find(task.recipe, task.suffix)
        design = task.dataset.design
        if path is not None:
            found.append(DesignBounds(design, read_bounds(path)))
        else:
            found.append(DesignBounds(design, (), _reason((task, *task.dependencies), outcomes)))
    return tuple(found)


@dataclass(frozen=True)
class _Known:
    """Inputs of the records of all designs.

    `outcomes` and `presses` go by key, `seed` is that of the study.
    """

    store: ArtefactStore
    outcomes: Mapping[str, Outcome]
    presses: Mapping[str, PressSummary]
    versions: Mapping[str, str]
    seed: int


def _collect_design(
    task: EvaluationTask, built: AccuracyTask | None, forces: ForceTask | None, known: _Known
) -> DesignResult:
    dataset = task.dataset
    tally = _read_tally(known.store.find(task.recipe, task.suffix))
    limits = known.store.find(task.bound.recipe, task.bound.suffix)
    predicted = known.store.find(built.recipe, built.suffix) if built else None
    keys = tuple(press.recipe.key for press in dataset.presses)
    summaries = tuple(known.presses[key] for key in keys if key in known.presses)
    parts: tuple[Task, ...] = (dataset, task.bound, task.estimator, task, *([forces] if forces else ()))
    return DesignResult(
        design=dataset.design,
        clean=Metrics.from_dict(tally["clean"]) if tally else None,
        jittered=Metrics.from_dict(tally["jittered"]) if tally else None,
        travel_mm=float(tally["travel_mm"]) if tally else float("nan"),
        force_n=summaries[0].force_n if summaries else float("nan"),
        peak_stress_mpa=max((press.peak_stress_mpa for press in summaries), default=float("nan")),
        bistable_from_mm=_bistable_from(known.store.find(task.inverted.recipe)),
        presses=summaries,
        counts=Counts(**tally["counts"]) if tally else None,
        seed=known.seed,
        versions=known.versions,
        artefacts={"press": keys, **{part.recipe.kind: (part.recipe.key,) for part in parts}},
        bounds=read_bounds(limits) if limits is not None else (),
        coverage=Coverage(**tally["coverage"]) if tally and tally["coverage"] else None,
        repeat_rmse_deg=tuple(tally["repeat_rmse_deg"]) if tally else (),
        spec=_spec(dataset, task),
        built=read_accuracy(predicted) if predicted else (),
        failure=_unpredicted(built, predicted, known)
        if tally
        else _reason((*reversed(parts), *dataset.presses), known.outcomes),
    )


def _unpredicted(built: AccuracyTask | None, found: Path | None, known: _Known) -> str:
    """Reason why the predicted accuracy is missing; empty if it exists or was not planned."""
    if built is None or found is not None:
        return ""
    return f"no prediction as built: {_reason((*built.twin.dependencies, built.twin, built), known.outcomes)}"


def _versions() -> dict[str, str]:
    stages = {"fea": "press", "dataset": "dataset", "limit": "error_bound", "learn": "estimator"}
    return {**provenance(), **{name: stage_version(stage) for name, stage in stages.items()}}


_SIZES = {"height", "base_radius", "thickness"}
"""Parameters that every skin has, and that have their own columns in the grid."""


def _azimuths(dataset: DatasetTask) -> dict[str, list[float]]:
    """Azimuths of the presses of a skin that is not of revolution."""
    if dataset.design.skin.symmetry is Symmetry.REVOLVED:
        return {}
    return {"azimuths_deg": sorted({item.obstacle.turn_deg for item in dataset.presses})}


def _spec(dataset: DatasetTask, task: EvaluationTask) -> dict[str, Any]:
    """Settings other than sizes and markers; all presses of a design share them except for the tilt."""
    press = dataset.presses[0]
    obstacle = press.obstacle.model_dump(mode="json", exclude={press.obstacle.position_name, "azimuth_deg"})
    positions = list(dict.fromkeys(item.obstacle.radial for item in dataset.presses))
    own = dataset.design.skin_spec.model_dump(mode="json", exclude=_SIZES)
    return {
        **({"skin": own} if own else {}),
        "mesh": press.mesh.model_dump(mode="json"),
        "material": press.design.material.key_data(),
        positions_field(press.obstacle): positions,
        **_azimuths(dataset),
        "obstacle": obstacle,
        "solver": press.solver.model_dump(mode="json"),
        "camera": dataset.design.camera_spec.model_dump(mode="json"),
        "dataset": dataset.spec.model_dump(mode="json"),
        "learning": task.spec.model_dump(mode="json"),
    }


def _reason(tasks: Sequence[Task], outcomes: Mapping[str, Outcome]) -> str:
    """Reason why the first failed one of these tasks failed."""
    reasons = (outcomes[task.recipe.key].reason for task in tasks if task.recipe.key in outcomes)
    return next((reason for reason in reasons if reason), "it was not computed")


def _bistable_from(path: Path | None) -> float:
    """Depth in mm from which the inverted state exists; nan if it does not, or was not sought."""
    if path is None:
        return float("nan")
    press = read_press(path)
    found = press.depth[press.branch == Branch.INVERTED]
    return float(found.min()) if len(found) else float("nan")


def _summarise_press(path: Path) -> PressSummary:
    press = read_press(path)
    moved = np.linalg.norm(press.displacement[-1], axis=1)
    column = "tilt_deg" if press.obstacle.pose_space.is_tilt else "offset_mm"
    return PressSummary(
        position=press.obstacle.radial,
        position_column=column,
        ended=str(press.ended),
        ended_depth_mm=float(press.ended_depth),
        force_n=float(np.linalg.norm(press.force[-1])),
        peak_stress_mpa=float(np.max(press.peak_stress)),
        branch=str(press.branch[-1]),
        displacement_max_mm=float(moved.max()),
        displacement_mean_mm=float(moved.mean()),
        apex_gap_mm=float(press.apex_gap[-1]),
        azimuth_deg=None if press.mesh.skin.symmetry is Symmetry.REVOLVED else press.obstacle.turn_deg,
    )


def _read_tally(path: Path | None) -> dict[str, Any]:
    if path is None:
        return {}
    content: dict[str, Any] = json.loads(path.read_text())
    return content
