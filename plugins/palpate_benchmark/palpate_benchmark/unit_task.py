"""Tasks behind the data set: the twin of each design, and the images of each unit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from palpate.core import ArtefactStore, Recipe, stage_version
from palpate.mesh import MeshSpec
from palpate.study import AsBuiltSpec, MaterialSpec, Task, TwinTask, find_artefact, plan_twin, single_design_study
from palpate.surrogate import read_twin
from palpate_benchmark.simulate_unit import simulate_unit
from palpate_benchmark.spec import BenchmarkDesign, BenchmarkSpec, TwinPressSpec
from palpate_benchmark.unit_images import write_unit_images

_ABOUT_IMAGES = {"url", "creator", "published", "licence", "designs", "train_units", "calibrate_units", "test_units"}
"""Fields that do not affect the images of a unit; `hidden_seed` is excluded except in the test."""


@dataclass(frozen=True)
class BenchmarkUnitTask(Task):
    """Task that simulates all images of one unit."""

    twin: TwinTask
    spec: BenchmarkSpec
    design: BenchmarkDesign
    unit: int

    @property
    def name(self) -> str:
        return f"unit {self.unit} of {self.design.name}"

    @cached_property
    def recipe(self) -> Recipe:
        hidden = self.spec.split_of(self.unit) == "test"
        left_out = _ABOUT_IMAGES | (set() if hidden else {"hidden_seed"})
        spec = {
            "set": self.spec.model_dump(mode="json", exclude=left_out),
            "design": self.design.model_dump(mode="json"),
            "unit": self.unit,
        }
        return Recipe("benchmark", spec, (self.twin.recipe.key,), stage_version("benchmark_unit"))

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (self.twin,)

    @property
    def cost(self) -> float:
        return 1e-3 * self.spec.presses * self.spec.images + 0.1 * self.spec.pictures

    def make(self, store: ArtefactStore) -> None:
        twin = read_twin(find_artefact(store, self.twin))
        found = simulate_unit(self.spec, self.design, self.unit, twin)
        store.write(self.recipe, lambda path: write_unit_images(path, found))


def plan_units(spec: BenchmarkSpec) -> tuple[BenchmarkUnitTask, ...]:
    """Plan the task of every unit of every design."""
    tasks = []
    for design in spec.designs:
        twin = plan_design_twin(spec, design, spec.twin)
        tasks += [BenchmarkUnitTask(twin, spec, design, unit) for unit in range(1, spec.units + 1)]
    return tuple(tasks)


def plan_design_twin(spec: BenchmarkSpec, design: BenchmarkDesign, presses: TwinPressSpec) -> TwinTask:
    """Plan the twin of one design from the given presses."""
    study = single_design_study(design.skin, design.marker_layout, MaterialSpec(name=spec.material))
    built = AsBuiltSpec(contacts=presses.contacts, inverted=presses.inverted, checks=presses.checks)
    wall = study.obstacle.model_copy(update={"depth": spec.depth, "depth_step": presses.depth_step})
    changed = {
        "mesh": MeshSpec(cells=presses.cells),
        "tilts_deg": presses.tilts_deg,
        "built": built,
        "obstacle": wall,
    }
    return plan_twin(study.model_copy(update=changed), design.skin)
