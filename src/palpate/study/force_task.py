"""Task that trains a force output of a design's estimator, by the forces of its presses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from palpate.core import ArtefactStore, Recipe, stage_version
from palpate.study.task import EstimatorTask, Task, find_artefact


@dataclass(frozen=True)
class ForceTask(Task):
    """Train a force output; the artefact is the estimator with pose (unchanged) and force."""

    estimator: EstimatorTask

    suffix = ".onnx"

    @property
    def name(self) -> str:
        return f"forces {self.estimator.name.removeprefix('estimator ')}"

    @cached_property
    def recipe(self) -> Recipe:
        inputs = tuple(task.recipe.key for task in (self.estimator, *self.estimator.dataset.dependencies))
        return Recipe(kind="forces", spec={}, inputs=inputs, version=stage_version("force_estimator"))

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (self.estimator, *self.estimator.dataset.dependencies)

    @property
    def cost(self) -> float:
        return 7.0

    def make(self, store: ArtefactStore) -> None:
        from palpate.learn import train_force_output  # here, so that a study already learned needs no torch

        estimator, chosen = find_artefact(store, self.estimator), self.estimator.spec
        dataset = self.estimator.dataset.generate(store, forces=True)
        store.write(
            self.recipe,
            lambda path: train_force_output(estimator, dataset, path, chosen.seed, chosen.device),
            self.suffix,
        )
