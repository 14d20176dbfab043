"""Design search: skins by a Gaussian process, rings and cameras by exchange."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from palpate.core import ArtefactStore, PalpateError, load_opencv, stage_version
from palpate.core.run import Progress
from palpate.core.store_lock import take_lock
from palpate.design import DomeSpec
from palpate.optimise.evaluate_skin import SkinEvaluationTask, plan_skin_evaluation
from palpate.optimise.front import Front, SearchBaselines, SkinTrial
from palpate.optimise.search_skins import (
    Evaluation,
    Sampler,
    SearchPlan,
    SearchTrial,
    read_trials,
    rewrite_journal,
    search_skins,
)
from palpate.optimise.skin_evaluation import SkinEvaluation
from palpate.optimise.space import Place, SkinSpace
from palpate.optimise.spec import RequirementsSpec
from palpate.optimise.validate_designs import predict_baseline, validate_designs, validation_cost
from palpate.study import Task, ensure_writable, find_artefact, run_tasks

JOURNAL = "search.journal"
"""Journal of the search in its folder."""
CONTROL = "control.journal"
"""Journal of the random search in it."""
ASKED = "requirements.json"
"""File of the requirements in it."""
_LOCK = "search.lock"
"""File that a running search locks: two would propose the same places."""
_SEARCHED = ("error", "force", "size")
"""Objectives that depend on the skin; each skin offers options over the remaining ones."""
_SLACK = 0.005
"""Relative tolerance of the required depth. By hand."""
_ROUNDS = 3
"""Rounds of finalists: skins that break a limit at full fidelity are replaced. By hand."""


def optimise_design(
    spec: RequirementsSpec,
    out: Path,
    workers: int | None = None,
    progress: Progress | None = None,
    *,
    sampler: Sampler = "gp",
    cluster: str = "",
) -> Front:
    """Search for the designs that best meet the requirements; `validate_front` simulates the result.

    Parameters
    ----------
    spec
        The requirements.
    out
        Result folder; the same call resumes an interrupted search, and no press is solved twice.
    workers, progress
        As for `palpate.study.run_study`; the result does not depend on them.
    sampler
        ``"random"`` draws skins at random, as a baseline.
    cluster
        A Dask cluster instead of workers, as for `palpate.study.run_study`.

    Raises
    ------
    PalpateError
        If the folder belongs to other requirements, another search runs in it, or it cannot be written.
    MissingExtraError
        If optuna, torch or OpenCV is not installed.
    """
    load_opencv()  # layouts are offered where images are read: not to be missed as skins that cannot be made
    space, evaluator = SkinSpace.of(spec), _Evaluator(spec, out, workers, progress, cluster)
    _keep(spec, sampler, out)
    searched = [name for name in spec.objectives if name in _SEARCHED] or ["error"]
    plan = SearchPlan(
        spec.skins,
        spec.seed,
        sampler,
        (space.place(DomeSpec()),),
        n_objectives=len(searched),
        max_hours=spec.max_hours,
    )
    if (lock := take_lock(out / _LOCK)) is None:
        raise PalpateError(
            f"Another search runs in {out}.",
            "Wait for its end, or give this one a folder of its own by --out.",
            code="search-running",
        )
    try:
        evaluator.expect(space, plan)
        trials = evaluator.search(space, plan, out / JOURNAL, evaluator.report_best)
        baseline = None
        if len(spec.objectives) > 1:
            evaluator.later.pop("baseline", None)
            baseline = predict_baseline(spec, out, evaluator.run)
        others = SearchBaselines(tuple(evaluator.draw(space, plan)), tuple(evaluator.grid()))
        front = Front(spec, tuple(map(evaluator.skin, trials)), baseline=baseline, search_baselines=others)
        return replace(front, trials=evaluator.finish(front)) if spec.finalists else front
    finally:
        lock.release()


def validate_front(
    front: Front, out: Path, workers: int | None = None, progress: Progress | None = None, cluster: str = ""
) -> Front:
    """Simulate the winner, finalists and baseline if the requirements ask for it; else return the front.

    The parameters are those of `optimise_design`, which found the front in `out`.
    """
    if front.spec.validation == "none" or front.winner is None:
        return front
    return replace(
        front, validation=validate_designs(front, out, _Evaluator(front.spec, out, workers, progress, cluster).run)
    )


def objective_values(spec: RequirementsSpec, proposal: SkinEvaluation) -> tuple[float, ...]:
    """Objective values of a skin; infinite if unknown (the sampler then uses the worst known value)."""
    best = proposal.best(spec.markers)
    known = {
        "error": math.log10(best.accuracy.p95_deg) if best else math.inf,
        "force": math.log10(proposal.force_n) if proposal.force_n else math.inf,
        "size": proposal.size_mm,
    }
    return tuple(known[name] for name in spec.objectives if name in known) or (known["error"],)


def constraint_violations(spec: RequirementsSpec, proposal: SkinEvaluation) -> dict[str, float]:
    """Relative excess of a skin over the limit of each constraint."""
    found = {"reach": 1.0 - _SLACK - proposal.max_depth_mm / spec.depth, "made": 1.0 if proposal.problem else -1.0}
    if spec.force_n is not None:
        found["force"] = proposal.force_n / spec.force_n - 1.0 if proposal.force_n else 0.0
    if spec.single_state:
        second = proposal.bistable_from_mm
        found["state"] = -1.0 if second is None else 1.0 - second / spec.depth
    return found


@dataclass(frozen=True)
class _Evaluator:
    """Evaluation of skins by tasks in the folder of the search."""

    spec: RequirementsSpec
    out: Path
    workers: int | None
    progress: Progress | None
    cluster: str
    later: dict[str, float] = field(default_factory=dict)
    """Expected cost of the parts to come: journals of searches and steps after them."""

    def expect(self, space: SkinSpace, plan: SearchPlan) -> None:
        """Set the cost of all parts, with those of the middle skin for skins that are not known yet."""
        spec, middle = self.spec, space.skin({name: sum(ends) / 2 for name, ends in space.ranges.items()})
        coarse, full = (
            plan_skin_evaluation(spec, middle, spec.materials[0], full=full).total_cost for full in (False, True)
        )
        longest = 3600.0 * spec.max_hours * (self.workers or os.cpu_count() or 1)
        left = {
            name: count - len(read_trials(self.out / name, plan.n_objectives))
            for name, count in ((JOURNAL, spec.skins), (CONTROL, spec.random_skins))
        }
        parts = {
            **{name: min(max(count, 0) * coarse, longest) for name, count in left.items()},
            "baseline": full if spec.baseline and (len(spec.objectives) > 1 or spec.validation != "none") else 0.0,
            "grid": sum(task.total_cost for task in self._grid_tasks()),
            "finalists": spec.finalists * full,
            "validation": validation_cost(spec),
        }
        self.later.update(parts)

    def search(
        self,
        space: SkinSpace,
        plan: SearchPlan,
        journal: Path,
        watch: Callable[[Sequence[SearchTrial]], None] | None = None,
    ) -> tuple[SearchTrial, ...]:
        """Search, and return the trials; a resumed search uses re-evaluated earlier trials."""
        before = read_trials(journal, plan.n_objectives)
        cost = self.later.setdefault(journal.name, 0.0) / max(plan.trials - len(before), 1)
        now = self.reevaluate(before)
        if now != before:
            rewrite_journal(journal, space, plan, now)

        def evaluate(places: Sequence[Place]) -> list[Evaluation]:
            self.later[journal.name] -= len(places) * cost
            return self.evaluate(places)

        trials = search_skins(space, evaluate, plan, journal, watch)
        del self.later[journal.name]
        return trials

    def evaluate(self, places: Sequence[Place]) -> list[Evaluation]:
        """Evaluate the skins at several places."""
        space = SkinSpace.of(self.spec)
        tasks = [plan_skin_evaluation(self.spec, space.skin(place), space.material(place)) for place in places]
        return [self._evaluation(proposal) for proposal in self._do(tasks)]

    def reevaluate(self, tried: Sequence[SearchTrial]) -> tuple[SearchTrial, ...]:
        """Evaluate the same skins by the present version; presses are reused."""
        old = [one for one in tried if one.evaluation.record.get("version") != _evaluation_version()]
        anew = dict(zip((one.number for one in old), self.evaluate([one.place for one in old]), strict=True))
        return tuple(
            replace(one, evaluation=anew.get(one.number) or self._evaluation(self.skin(one).coarse)) for one in tried
        )

    def _evaluation(self, proposal: SkinEvaluation) -> Evaluation:
        note = {"proposal": proposal.to_data(), "version": _evaluation_version()}
        return Evaluation(objective_values(self.spec, proposal), constraint_violations(self.spec, proposal), note)

    def report_best(self, tried: Sequence[SearchTrial]) -> None:
        """Report the number of trials and the minimum error of feasible skins."""
        if self.progress is None:
            return
        best = min(
            Front(self.spec, tuple(map(self.skin, tried))).candidates,
            key=lambda entry: entry.value("error"),
            default=None,
        )
        so_far = (
            f"skin {best.trial.number} reads best, {best.value('error'):.4f}°" if best else "none meets the limits"
        )
        self.progress.note(f"{len(tried)} of {self.spec.skins} skins tried: {so_far}.")

    @staticmethod
    def skin(tried: SearchTrial) -> SkinTrial:
        """Return the trial of a skin from its journal entry."""
        judged = tried.evaluation
        return SkinTrial(tried.number, SkinEvaluation.from_data(judged.record["proposal"]), judged.violations)

    def draw(self, space: SkinSpace, plan: SearchPlan) -> Iterator[SkinTrial]:
        """Yield the trials of the random search, evaluated like those of the search."""
        if self.spec.random_skins:
            chance = replace(plan, trials=self.spec.random_skins, sampler="random")
            yield from map(self.skin, self.search(space, chance, self.out / CONTROL))

    def grid(self) -> Iterator[SkinTrial]:
        """Yield the evaluated designs of the grid."""
        self.later.pop("grid", None)
        found = self._do(self._grid_tasks())
        return (SkinTrial(number, one, constraint_violations(self.spec, one)) for number, one in enumerate(found))

    def _grid_tasks(self) -> list[SkinEvaluationTask]:
        grid, material = self.spec.baseline_grid, self.spec.materials[0]
        skins = grid.designs.skins() if grid else ()
        return [plan_skin_evaluation(self.spec, skin, material, grid=grid) for skin in skins]

    def finish(self, front: Front) -> tuple[SkinTrial, ...]:
        """Press the best skins at full fidelity; replace those that break a limit there by the next ones."""
        by_number = {one.number: one for one in front.trials}
        candidates, wanted = _candidates(front), self.spec.finalists
        self.later.pop("finalists", None)
        for _ in range(_ROUNDS):
            asked = [by_number[number] for number in candidates[:wanted]]
            del candidates[:wanted]
            tasks = [
                plan_skin_evaluation(self.spec, one.coarse.skin, one.coarse.material, full=True) for one in asked
            ]
            for one, full in zip(asked, self._do(tasks), strict=True):
                by_number[one.number] = replace(one, fine=full, violations=constraint_violations(self.spec, full))
            wanted = sum(not by_number[one.number].feasible for one in asked)
        return tuple(by_number.values())

    def run(self, tasks: Sequence[Task]) -> dict[str, str]:
        """Run tasks; return the reasons of failure by task key."""
        if self.progress is not None:
            self.progress.expect(sum(self.later.values()))
        return run_tasks(self.out, tasks, self.workers, self.progress, self.cluster) if tasks else {}

    def _do(self, tasks: Sequence[SkinEvaluationTask]) -> list[SkinEvaluation]:
        reasons = self.run(tasks)
        store = ArtefactStore(self.out / "store")
        return [
            SkinEvaluation(task.skin, task.material, problem=reasons[task.recipe.key])
            if task.recipe.key in reasons
            else SkinEvaluation.from_data(json.loads(find_artefact(store, task).read_text("utf-8")))
            for task in tasks
        ]


def _evaluation_version() -> str:
    """Version of an evaluation in the journal: those of its stage, of twins and of presses."""
    return "; ".join(map(stage_version, ("skin_evaluation", "twin", "press")))


def _candidates(front: Front) -> list[int]:
    """Numbers of distinct feasible skins: winner, extremes, front, then the remaining ones by error."""
    first, best = front.spec.objectives[0], dict[int, float]()
    for entry in front.candidates:
        value = entry.value(first)
        best[entry.trial.number] = min(value, best.get(entry.trial.number, value))
    chosen = [front.winner.trial.number] if front.winner else []
    chosen += [entry.trial.number for _, entry in front.extremes]
    chosen += [entry.trial.number for entry in front.pareto if len(front.spec.objectives) > 1]
    chosen += sorted(best, key=lambda number: (best[number], number))
    first_of = {repr(front.trials[number].coarse.skin): number for number in reversed(chosen)}
    return sorted(first_of.values(), key=chosen.index)


def _keep(spec: RequirementsSpec, sampler: str, out: Path) -> None:
    """Store the requirements; reject a folder of different ones, except for a longer search."""
    asked = {**spec.model_dump(mode="json"), "sampler": sampler}
    free = {
        "skins",
        "max_hours",
        "finalists",
        "error_deg",
        "name",
        "validation",
        "baseline",
        "random_skins",
        "baseline_grid",
    }
    file = ensure_writable(out) / ASKED
    if file.exists():
        before = json.loads(file.read_text("utf-8"))
        other = sorted(name for name in asked if name not in free and asked[name] != before.get(name))
        if other:
            raise PalpateError(
                f"{out} holds a search of other requirements: {', '.join(other)}.",
                "Give another --out.",
                code="search-requirements-differ",
            )
    file.write_text(json.dumps(asked, indent=2) + "\n", "utf-8")
