"""Validation of a search: winner and baseline on the test bench, and the winner by CalculiX.

Each simulated unit, press and network is an artefact of the search's store, so that an interrupted validation
resumes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from palpate.calibration import ContradictionError, Deviation, PredictedAccuracy, predict_accuracy, sample_deviation
from palpate.core import ArtefactStore, FloatArray, PalpateError, Recipe
from palpate.design import Design
from palpate.fea import (
    CalculixSolver,
    Press,
    WallSpec,
    calculix_recipe,
    read_press,
    solve_press_calculix,
    write_press,
)
from palpate.material import get_material
from palpate.mesh import mesh_skin
from palpate.optimise.design_study import design_of, design_study
from palpate.optimise.evaluate_skin import SkinEvaluationTask, accuracy_spec, plan_skin_evaluation
from palpate.optimise.front import DesignCandidate, Front
from palpate.optimise.spec import RequirementsSpec
from palpate.optimise.validation import SimulatedAccuracy, SolverComparison, ValidatedDesign, ValidationResult
from palpate.simulation import VirtualBench, VirtualBenchSpec, read_trial, run_unit_trial, unit_recipe
from palpate.study import PressTask, Task, TwinTask, find_artefact, plan_study, resolve_device
from palpate.surrogate import read_twin

UNITS = 20
"""Simulated units of each design. By hand."""
_MOST_KNOWN = 5
"""Maximum number of calibration presses on the bench. By hand."""
_FINALISTS = 2
"""Finalists that are simulated with the winner if there is one objective. By hand."""
_TRAINING_S = 200.0
"""Expected time of presses, images and training of one design, s."""


@dataclass(frozen=True)
class UnitTrialTask(Task):
    """Simulate one built unit of a design on the test bench."""

    reader: Task
    """Task that makes the estimator: the design's twin, or a trained network."""
    design: Design
    spec: VirtualBenchSpec
    unit: int

    suffix = ".json"

    @property
    def name(self) -> str:
        design = f"{self.design.skin.name} {len(self.design.layout)} markers"
        return f"unit {self.unit} of {design}, {self.reader.recipe.kind}"

    @cached_property
    def recipe(self) -> Recipe:
        return unit_recipe(self._bench(Path(), ArtefactStore(Path())), self._deviation)

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return (self.reader,)

    @property
    def cost(self) -> float:
        return _trial_cost(self.spec)

    def make(self, store: ArtefactStore) -> None:
        bench = self._bench(find_artefact(store, self.reader), store)
        bench.check()
        run_unit_trial(bench, self._deviation)

    def read(self, store: ArtefactStore) -> dict[str, Any]:
        """Return the sums over the unit's images."""
        trial = read_trial(find_artefact(store, self), self._deviation)
        errors = trial.corrected() - trial.truth
        seen = np.isfinite(errors).all(axis=1)
        return {
            "images": len(errors),
            "seen": int(seen.sum()),
            "squares": (errors[seen] ** 2).sum(axis=0).tolist(),
            "p95_deg": float(np.abs(errors[seen, :2]).max(initial=0.0)),
            "failure": trial.failure,
        }

    @property
    def _deviation(self) -> Deviation:
        return sample_deviation(self.spec.tolerance, self.spec.seed, self.unit)

    def _bench(self, model: Path, store: ArtefactStore) -> VirtualBench:
        """Return the bench of this design, named by the recipe of its model."""
        return VirtualBench(self.spec, self.design, model, store, self.reader.recipe.key)


def _trial_cost(bench: VirtualBenchSpec) -> float:
    """Expected time of the trial of one unit, s."""
    return 5.0 * (bench.tilts + 2 * bool(bench.calibration_presses)) * (bench.depth / 8.0) ** 0.5


@dataclass(frozen=True)
class CalculixTask(Task):
    """Solve a press by CalculiX."""

    press: PressTask

    @property
    def name(self) -> str:
        return f"{self.press.name} by CalculiX"

    @cached_property
    def recipe(self) -> Recipe:
        return calculix_recipe(self.press.design, self.press.mesh, self.press.obstacle)

    @property
    def dependencies(self) -> tuple[Task, ...]:
        return ()

    @property
    def cost(self) -> float:
        return 60.0 * self.press.obstacle.depth / 8.0

    def make(self, store: ArtefactStore) -> None:
        mesh = mesh_skin(self.press.design.skin, self.press.mesh)
        press = solve_press_calculix(mesh, self.press.design.material, self.press.obstacle)
        store.write(self.recipe, lambda path: write_press(path, press))


def validate_designs(front: Front, out: Path, do: Callable[[Sequence[Task]], Mapping[str, str]]) -> ValidationResult:
    """Simulate the winner of a front, finalists and baseline.

    Parameters
    ----------
    front
        A front with a winner.
    out
        Folder of the search.
    do
        Runs tasks, and returns the reasons of failure by task key.
    """
    assert front.winner is not None
    spec, store = front.spec, ArtefactStore(out / "store")
    designs = [_Candidate.of(front, title, entry) for title, entry in _finalists(front, front.winner)]
    designs += [_Candidate.rival(spec)] if spec.baseline else []
    winner = designs[0]
    second, problem = winner.second_solver()
    tasks = [task for one in designs for task in (*one.predicted_by, *one.units, *one.trained_units)]
    reasons = do([*tasks, *second])
    problem = problem or next((reasons[task.recipe.key] for task in second if task.recipe.key in reasons), "")
    return ValidationResult(
        designs=tuple(design.evaluate(store, reasons) for design in designs),
        calibration_presses=winner.bench.calibration_presses,
        second=None if problem else _compare(store, second, winner.design.layout.positions),
        second_problem=problem,
    )


def predict_baseline(
    spec: RequirementsSpec, out: Path, do: Callable[[Sequence[Task]], Mapping[str, str]]
) -> PredictedAccuracy | None:
    """Predict the accuracy of the baseline from its validation twin; `None` without a baseline.

    The parameters are those of `validate_designs`.
    """
    if spec.baseline is None:
        return None
    rival, store = _Candidate.rival(spec), ArtefactStore(out / "store")
    return None if do(rival.predicted_by) else rival.predict(store)


def validation_cost(spec: RequirementsSpec) -> float:
    """Expected time of the validation on one core, s, without twins."""
    if spec.validation == "none":
        return 0.0
    several = len(spec.objectives)
    designs = several if several > 1 else 1 + min(_FINALISTS, max(spec.finalists - 1, 0))
    trained = _TRAINING_S + UNITS * _trial_cost(_bench_spec(spec)) if spec.validation == "trained" else 0.0
    return (designs + bool(spec.baseline)) * (UNITS * _trial_cost(_bench_spec(spec)) + trained)


def _bench_spec(spec: RequirementsSpec) -> VirtualBenchSpec:
    """Return the bench on which the designs of a search are simulated."""
    return VirtualBenchSpec(
        units=UNITS,
        max_tilt_deg=spec.max_tilt_deg,
        depth=spec.depth,
        min_depth=spec.min_depth,
        calibration_presses=min(spec.calibration_presses, _MOST_KNOWN),
        tolerance=spec.tolerance,
        seed=spec.seed,
    )


@dataclass(frozen=True)
class _Candidate:
    """Design to simulate."""

    spec: RequirementsSpec
    title: str
    design: Design
    material: str
    """Name of the elastomer in the requirements."""

    @classmethod
    def of(cls, front: Front, title: str, entry: DesignCandidate) -> _Candidate:
        """Return the candidate of a design of the front."""
        return cls(front.spec, title, design_of(front.spec, entry), entry.trial.finest.material)

    @classmethod
    def rival(cls, spec: RequirementsSpec) -> _Candidate:
        """Return the baseline of the requirements, with the first of the cameras and elastomers."""
        assert spec.baseline is not None
        camera = spec.cameras[0].camera.model_copy(update={"distance": spec.baseline.distance})
        material = spec.materials[0]
        design = Design(spec.baseline.skin(), spec.baseline.markers, camera, get_material(material))
        return cls(spec, "rival", design, material)

    @cached_property
    def bench(self) -> VirtualBenchSpec:
        return _bench_spec(self.spec)

    @cached_property
    def _proposal(self) -> SkinEvaluationTask:
        return plan_skin_evaluation(self.spec, self.design.skin_spec, self.material, full=True)

    @property
    def twin(self) -> TwinTask:
        return self._proposal.twin

    @property
    def predicted_by(self) -> tuple[Task, ...]:
        """Tasks of the twin and of the presses that measure its error."""
        return (self.twin, *(press for checks in self._proposal.checks for press in checks.presses))

    @cached_property
    def units(self) -> tuple[UnitTrialTask, ...]:
        return self._simulate(self.twin, self.bench)

    @cached_property
    def trained_units(self) -> tuple[UnitTrialTask, ...]:
        if self.spec.validation != "trained":
            return ()
        study = design_study(self.spec, self.spec.name, self.design, self.material)
        estimator = plan_study(resolve_device(study)).designs[0].estimator
        return self._simulate(estimator, self.bench.model_copy(update={"calibration_presses": 0}))

    def _simulate(self, reader: Task, bench: VirtualBenchSpec) -> tuple[UnitTrialTask, ...]:
        return tuple(UnitTrialTask(reader, self.design, bench, unit) for unit in range(1, UNITS + 1))

    def second_solver(self) -> tuple[tuple[Task, ...], str]:
        """Return the tasks of a press by palpate and by CalculiX, and the reason if CalculiX cannot solve it."""
        wall = WallSpec(tilt_deg=self.spec.max_tilt_deg, contact="frictionless", depth=self.spec.depth)
        straight = self.twin.presses[0]
        plain = straight.solver.model_copy(update={"derivatives": ()})
        own = replace(straight, obstacle=wall, solver=plain)
        try:
            CalculixSolver().check(wall)
        except PalpateError as error:
            return (), str(error.problem)
        return (own, CalculixTask(own)), ""

    def predict(self, store: ArtefactStore) -> PredictedAccuracy | None:
        """Predict the accuracy from the twin and its validation presses; `None` if these contradict the twin."""
        twin, spec = (
            read_twin(find_artefact(store, self.twin)),
            replace(accuracy_spec(self.spec), calibration_presses=self.bench.calibration_presses),
        )
        layout, camera = self.design.layout, self.design.camera
        checks = [each.find(store) for each in self._proposal.checks]
        try:
            return predict_accuracy(twin, layout, camera, self.spec.tolerance, spec, checks)
        except ContradictionError:
            return None

    def evaluate(self, store: ArtefactStore, reasons: Mapping[str, str]) -> ValidatedDesign:
        """Return predicted and simulated accuracy."""
        empty = ValidatedDesign(
            self.title,
            self.design.skin.name,
            len(self.design.layout),
            self.design.camera_spec.distance,
            0.0,
            predicted=None,
            simulated=None,
        )
        lacks = next((task for task in self.predicted_by if store.find(task.recipe) is None), None)
        if lacks is not None:
            return replace(empty, problem=reasons.get(lacks.recipe.key, f"There is no {lacks.name}."))
        presses = (read_press(find_artefact(store, press)) for press in self.twin.presses)
        gathered, failures = _gather(store, self.units, reasons)
        return replace(
            empty,
            problem="" if gathered else failures[0],
            force_n=max(float(np.linalg.norm(press.force, axis=1).max()) for press in presses),
            predicted=self.predict(store),
            simulated=gathered,
            trained=_gather(store, self.trained_units, reasons)[0],
        )


def _finalists(front: Front, winner: DesignCandidate) -> Iterator[tuple[str, DesignCandidate]]:
    """Yield the winner, and the extremes of the front; for one objective, the best other finalists."""
    if front.extremes:
        yield from _together([("winner", winner), *front.extremes])
        return
    yield "winner", winner
    others = sorted(
        (
            DesignCandidate(one, option)
            for one in front.trials
            if one.fine is not None and one.feasible and one.number != winner.trial.number
            if (option := one.fine.best(front.spec.markers)) is not None
        ),
        key=lambda entry: entry.value("error"),
    )
    for entry in others[:_FINALISTS]:
        yield f"skin {entry.trial.number}", entry


def _together(titled: Sequence[tuple[str, DesignCandidate]]) -> Iterator[tuple[str, DesignCandidate]]:
    """Yield every design once, with all of its titles."""
    entries: list[DesignCandidate] = []
    for _, entry in titled:
        if entry not in entries:
            entries.append(entry)
    for entry in entries:
        yield ", ".join(title for title, other in titled if other == entry), entry


def _gather(
    store: ArtefactStore, tasks: Sequence[UnitTrialTask], reasons: Mapping[str, str]
) -> tuple[SimulatedAccuracy | None, list[str]]:
    """Combine the results of all simulated units of a design, and the reasons of failed ones."""
    failures = [reasons[task.recipe.key] for task in tasks if task.recipe.key in reasons]
    made = (task for task in tasks if task.recipe.key not in reasons)
    found = {task.recipe.key: task.read(store) for task in made}
    failures += [unit["failure"] for unit in found.values() if unit["failure"]]
    units = [unit for unit in found.values() if unit["seen"]]
    if not units:
        return None, failures or ["No image of any unit gave a pose."]
    images, seen = (sum(unit[name] for unit in units) for name in ("images", "seen"))
    squares = np.sum([unit["squares"] for unit in units], axis=0) / seen
    figure = SimulatedAccuracy(
        units=len(units),
        images=images,
        without_pose=images - seen,
        rmse_deg=float(np.sqrt(squares[:2].mean())),
        p95_deg=float(np.quantile([unit["p95_deg"] for unit in units], 0.95)),
        depth_rmse=float(np.sqrt(squares[2])),
        failures=tuple(failures),
        by_unit=tuple(_by_unit(found.get(task.recipe.key)) for task in tasks),
    )
    return figure, failures


def _by_unit(unit: Mapping[str, Any] | None) -> tuple[float, float] | None:
    """RMSE of rx and ry, and maximum error, of a unit; `None` if it failed or gave no pose."""
    if unit is None or not unit["seen"]:
        return None
    return math.sqrt(sum(unit["squares"][:2]) / 2 / unit["seen"]), float(unit["p95_deg"])


def _compare(store: ArtefactStore, tasks: Sequence[Task], dots: FloatArray) -> SolverComparison:
    """Compare CalculiX and palpate at the maximum depth that both reached in the same state."""
    own, other = (read_press(find_artefact(store, task)) for task in tasks)
    reached = other.depth[other.depth <= own.depth[-1] + 1e-6]
    nearest = np.abs(own.depth - reached[:, None]).argmin(axis=1)
    parted = np.append(own.branch[nearest] != other.branch[: len(reached)], True)
    first = int(parted.argmax())
    depth = reached[max(first - 1, 0)]
    at = partial(_at_depth, depth=depth, dots=dots)
    (force, here), (second_force, there) = at(own), at(other)
    apart = np.sqrt(np.mean(np.sum((here - there) ** 2, axis=1)))
    parts = float(reached[first]) if first < len(reached) else None
    return SolverComparison(float(depth), second_force, force, float(apart), parts)


def _at_depth(press: Press, depth: float, dots: FloatArray) -> tuple[float, FloatArray]:
    """Return the contact force, N, and marker positions (m, 3) of the increment nearest to a depth."""
    nearest = int(np.abs(press.depth - depth).argmin())
    return float(np.linalg.norm(press.force[nearest])), press.positions(dots)[nearest]
