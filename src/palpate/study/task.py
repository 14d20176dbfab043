"""Tasks of a study, from press to learning, each a pure function of its inputs, stored under a key."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

from palpate.core import ArtefactStore, PalpateError, Recipe, stage_version
from palpate.datasets import (
    Dataset,
    DatasetSpec,
    PerturbedPresses,
    dataset_version,
    generate_dataset,
    read_dataset,
    write_dataset,
)
from palpate.design import Design, Symmetry
from palpate.fea import Branch, ObstacleSpec, press_recipe, read_press, solve_press, write_press
from palpate.learn import PAPER_SPACE, ErrorBound, LearningSpec, TrainingSpec
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import build_field


class MissingArtefactError(PalpateError):
    """Error of a missing or broken input artefact; `key` is that of its recipe."""

    code = "artefact-missing"

    def __init__(self, what: str, key: str) -> None:
        super().__init__(what, "Run the study again.", code=self.code)
        self.key = key


class Task(ABC):
    """One artefact to be made."""

    suffix: str = ".h5"

    @property
    @abstractmethod
    def name(self) -> str:
        """Label of the task, e.g. ``"press H20 T2 tilt 4°"``."""

    @property
    @abstractmethod
    def recipe(self) -> Recipe:
        """All inputs that determine the content of the artefact."""

    @property
    @abstractmethod
    def dependencies(self) -> tuple[Task, ...]:
        """Tasks whose artefacts this one reads."""

    @property
    @abstractmethod
    def cost(self) -> float:
        """Expected time on one core, s; only its order of magnitude matters."""

    @property
    def total_cost(self) -> float:
        """Expected time of the task and all its dependencies, s; a shared one counts each time."""
        return self.cost + sum(need.total_cost for need in self.dependencies)

    @property
    def urgency(self) -> float:
        """Weight in the order of tasks: the cost, unless a task must begin early."""
        return self.cost

    @abstractmethod
    def make(self, store: ArtefactStore) -> None:
        """Make the artefact and put it into the store."""


@dataclass(frozen=True)
class PressTask(Task):
    """Press of one skin at one position of an obstacle, on the flat or the inverted branch."""

    design: Design
    """Only its skin and elastomer matter; presses of designs that differ in the rest are the same."""
    mesh: MeshSpec
    obstacle: ObstacleSpec
    solver: SolverSpec
    branch: Branch = Branch.FLAT

    @property
    def name(self) -> str:
        state = " inverted" if self.branch is Branch.INVERTED else ""
        friction = "" if isinstance(self.obstacle.contact, str) else f" friction {self.obstacle.contact:g}"
        skin = self.design.skin
        turned = skin.symmetry is not Symmetry.REVOLVED and self.obstacle.radial > 0
        azimuth = f" azimuth {self.obstacle.turn_deg:g}°" if turned else ""
        tilted = self.obstacle.pose_space.is_tilt
        position = f"tilt {self.obstacle.radial:g}°" if tilted else f"offset {self.obstacle.radial:g} mm"
        return f"press {skin.name} {position}{azimuth}{friction}{state}"

    @cached_property
    def recipe(self) -> Recipe:
        solver = self.solver.model_dump(mode="json")
        return press_recipe(
            self.design.skin_spec, self.mesh, self.design.material, self.obstacle, solver, self.branch
        )

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return ()

    @property
    def cost(self) -> float:
        # measured on H 10 to 30, T 1 to 3.6, 5 to 25 increments, 2 to 8 mm: standard deviation 21 %
        # to 25 cells; at 33 to 60 cells within a factor of 1.8
        wall, mesh, skin = self.obstacle, self.mesh, self.design.skin
        finer = 1.0 if mesh.cells is None else mesh.cells / 22.0
        cells = max(finer**0.7, finer**1.7)
        body = cells * (10.0 if mesh.filled else 1.0) * (2.0 if mesh.whole else 1.0)
        flatness = min(max(skin.base_radius / skin.height, 0.5), 2.0) ** 0.8
        increments = flatness * (wall.depth / skin.thickness * wall.depth / wall.depth_step) ** 0.5
        slips = 1.0 if isinstance(wall.contact, str) else 1.8 + 0.7 * min(wall.contact, 2.0)
        solver = (1.9 if self.solver.derivatives else 1.0) * (2.0 if self.branch is Branch.INVERTED else 1.0)
        return 0.27 * body * increments * slips * solver

    @property
    def urgency(self) -> float:
        # an inverted state begins early: twins of both branches wait for it
        return self.cost * (20.0 if self.branch is Branch.INVERTED else 1.0)

    def make(self, store: ArtefactStore) -> None:
        mesh = mesh_skin(self.design.skin, self.mesh)
        press = solve_press(mesh, self.design.material, self.obstacle, self.solver, self.branch)
        store.write(self.recipe, lambda path: write_press(path, press))


@dataclass(frozen=True)
class DatasetTask(Task):
    """Make the images of one design from the presses of its skin."""

    presses: tuple[PressTask, ...]
    design: Design
    spec: DatasetSpec
    perturbed_presses: tuple[tuple[PressTask, ...], ...] = ()
    """Presses of `spec.randomise`: one group a friction, thinner, thicker, one an obstacle."""

    @property
    def name(self) -> str:
        return f"dataset {self.design.skin.name} {len(self.design.layout)} markers"

    @cached_property
    def recipe(self) -> Recipe:
        spec = {
            "markers_mm": self.design.layout.positions.tolist(),
            "camera": self.design.camera_spec.model_dump(mode="json"),
            "dataset": self.spec.model_dump(mode="json"),
        }
        inputs = tuple(press.recipe.key for press in self.dependencies)
        return Recipe(kind="dataset", spec=spec, inputs=inputs, version=dataset_version(self.design.camera))

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (*self.presses, *(press for group in self.perturbed_presses for press in group))

    @property
    def cost(self) -> float:
        return 0.005 * len(self.design.layout)

    def make(self, store: ArtefactStore) -> None:
        dataset = self.generate(store)
        store.write(self.recipe, lambda path: write_dataset(path, dataset))

    def generate(self, store: ArtefactStore, *, forces: bool = False) -> Dataset:
        """Generate the images from the presses of a store, on request with contact forces."""
        groups = [
            [read_press(find_artefact(store, task)) for task in group]
            for group in (self.presses, *self.perturbed_presses)
        ]
        varied = self.spec.randomise
        first, last = (
            1 + len(varied.frictions if varied else ()),
            len(groups) - len(varied.obstacles if varied else ()),
        )
        relatives = PerturbedPresses(*(tuple(groups[begin:end]) for begin, end in pairwise((1, first, last, None))))
        return generate_dataset(groups[0], self.design.layout, self.design.camera, self.spec, relatives, forces)


@dataclass(frozen=True)
class BoundTask(Task):
    """Bound the errors of any estimator of one design, from the presses of its skin alone."""

    dataset: DatasetTask

    suffix = ".json"

    @property
    def name(self) -> str:
        return f"limit {self.dataset.design.skin.name} {len(self.dataset.design.layout)} markers"

    @cached_property
    def recipe(self) -> Recipe:
        dataset = self.dataset.recipe
        return Recipe(kind="limit", spec=dataset.spec, inputs=dataset.inputs, version=stage_version("error_bound"))

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return self.dataset.presses

    @property
    def cost(self) -> float:
        return 0.5

    def make(self, store: ArtefactStore) -> None:
        from palpate.learn import compute_error_bounds  # here, so that a study already judged compiles nothing

        dataset = self.dataset
        presses = [read_press(find_artefact(store, task)) for task in dataset.presses]
        field = build_field(presses, dataset.design.layout)
        camera = dataset.design.camera
        # near the axis the place of a line does not determine its direction: there is no bound
        limits = () if field.space.is_line else compute_error_bounds(field, camera, dataset.spec, dataset.spec.seed)
        store.write(self.recipe, lambda path: write_json(path, [asdict(limit) for limit in limits]), self.suffix)


@dataclass(frozen=True)
class EstimatorTask(Task):
    """Train one design's estimator; the artefact is a stand-alone model file."""

    dataset: DatasetTask
    spec: LearningSpec

    suffix = ".onnx"

    @property
    def name(self) -> str:
        return f"estimator {self.dataset.design.skin.name} {len(self.dataset.design.layout)} markers"

    @cached_property
    def recipe(self) -> Recipe:
        spec = self.spec.model_dump(mode="json")
        if self.spec.preset != "paper":
            spec["training"] = TrainingSpec().model_dump(mode="json")
        return Recipe(
            kind="estimator", spec=spec, inputs=(self.dataset.recipe.key,), version=stage_version("estimator")
        )

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (self.dataset,)

    @property
    def cost(self) -> float:
        trials = self.spec.trials or PAPER_SPACE.trials
        return {"quick": 8.0, "best": 40.0, "paper": 27.0 * trials}[self.spec.preset]

    def make(self, store: ArtefactStore) -> None:
        from palpate.learn import (  # here, so that a study already learned needs no torch
            search_estimator,
            write_estimator,
        )

        dataset = read_dataset(find_artefact(store, self.dataset))
        journal = store.path(self.recipe, ".journal")
        journal.parent.mkdir(parents=True, exist_ok=True)
        estimator = search_estimator(dataset, self.spec, journal)
        store.write(self.recipe, lambda path: write_estimator(path, estimator), self.suffix)


@dataclass(frozen=True)
class EvaluationTask(Task):
    """Measure the errors of one design's estimator on held-out presses; reject errors below the bound."""

    dataset: DatasetTask
    spec: LearningSpec
    inverted: PressTask
    """Press of the inverted state of the skin; it is not used in training."""

    suffix = ".json"

    @property
    def name(self) -> str:
        return f"learning {self.dataset.design.skin.name} {len(self.dataset.design.layout)} markers"

    @cached_property
    def bound(self) -> BoundTask:
        """Return the task of the bounds that the errors are compared with."""
        return BoundTask(self.dataset)

    @cached_property
    def estimator(self) -> EstimatorTask:
        """Return the task of the estimator."""
        return EstimatorTask(self.dataset, self.spec)

    @cached_property
    def recipe(self) -> Recipe:
        return Recipe(
            kind="learning",
            spec={"seed": self.spec.seed},
            inputs=tuple(task.recipe.key for task in self.dependencies),
            version=stage_version("test_errors"),
        )

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (self.dataset, self.bound, self.estimator)

    @property
    def cost(self) -> float:
        return 0.5

    def make(self, store: ArtefactStore) -> None:
        from palpate.learn import evaluate, find_leakage, measure_coverage, read_estimator

        dataset = read_dataset(find_artefact(store, self.dataset))
        estimator = read_estimator(find_artefact(store, self.estimator))
        clean, jittered = evaluate(estimator, dataset, None), evaluate(estimator, dataset, self.spec.seed)
        leak = find_leakage(jittered, read_bounds(find_artefact(store, self.bound)), dataset.spec)
        if leak:
            raise PalpateError(
                leak, "Look for a press, or a pose, that stands on both sides of the split.", code="evaluation-leaks"
            )
        coverage = measure_coverage(estimator, dataset, self.spec.seed)
        tally = {
            "clean": clean.as_dict(),
            "jittered": jittered.as_dict(),
            "repeat_rmse_deg": estimator.repeat_rmse_deg,
            "coverage": asdict(coverage) if coverage else None,
            "travel_mm": dataset.full_depth_travel_mm(),
            "counts": {
                "presses": dataset.solved_presses,
                "virtual_presses": dataset.virtual_presses,
                "samples": len(dataset.poses),
                "validation_samples": int(dataset.validation.sum()),
                "dropped": dict(dataset.dropped),
            },
        }
        store.write(self.recipe, lambda path: write_json(path, tally), self.suffix)


def read_bounds(path: Path) -> tuple[ErrorBound, ...]:
    """Read the artefact of a `BoundTask`, by ascending depth."""
    return tuple(ErrorBound(**item) for item in json.loads(path.read_text()))


def find_artefact(store: ArtefactStore, task: Task) -> Path:
    """Return the path of the artefact of a completed task.

    Raises
    ------
    MissingArtefactError
        If it is missing or broken.
    """
    path = store.find(task.recipe, task.suffix)
    if path is None:
        raise MissingArtefactError(f"The artefact of '{task.name}' is missing or broken.", task.recipe.key)
    return path


def write_json(path: Path, content: Any) -> None:
    """Write plain data; non-finite numbers are rejected."""
    path.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n")
