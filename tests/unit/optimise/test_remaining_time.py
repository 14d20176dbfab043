"""The remaining time that a search reports: one estimate for batches, baselines, finalists and validation."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from palpate.core import ArtefactStore
from palpate.core.run import Progress
from palpate.optimise import BaselineDesignSpec, RequirementsSpec, optimise_design, validate_front
from palpate.optimise.evaluate_skin import SkinEvaluationTask
from palpate.study import Task, write_json
from palpate.study.plan import with_dependencies
from small_search import evaluation_of

pytest.importorskip("optuna")
pytest.importorskip("torch")


@pytest.mark.parametrize("validation", ["none", "simulated"])
@pytest.mark.parametrize("skins", [16, 40])
def test_the_remaining_time_of_a_search_is_within_1_5_from_a_tenth_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, skins: int, validation: str
) -> None:
    now, found, asked = [0.0], set[str](), list[tuple[float, float | None]]()
    progress = Progress(lambda: now[0])

    def run(out: Path, tasks: Sequence[Task], *options: Any) -> dict[str, str]:
        """Let every task take half its cost, and store evaluations that are made up."""
        todo = [task for task in with_dependencies(tasks) if task.recipe.key not in found]
        found.update(task.recipe.key for task in todo)
        progress.plan(sum(task.cost for task in todo))
        for task in todo:
            progress.begin(task.name, task.cost)
            now[0] += 0.5 * task.cost
            progress.finish(task.name)
            asked.append((now[0], progress.remaining_s))
        for task in tasks:
            if isinstance(task, SkinEvaluationTask):
                made = evaluation_of(task.skin).to_data()
                ArtefactStore(out / "store").write(
                    task.recipe, lambda path, made=made: write_json(path, made), ".json"
                )
        return {} if isinstance(tasks[0], SkinEvaluationTask) else {task.recipe.key: "made up" for task in tasks}

    monkeypatch.setattr(sys.modules[optimise_design.__module__], "run_tasks", run)
    spec = RequirementsSpec(
        force_n=2.0, thicknesses=(2.0, 4.0), skins=skins, finalists=2, random_skins=8, depth=6.0, markers=37,
        validation=validation, baseline=BaselineDesignSpec(),
    )  # fmt: skip
    front = optimise_design(spec, tmp_path, progress=progress, sampler="random")
    validate_front(front, tmp_path, progress=progress)
    total = now[0]
    late = [(total - at, said) for at, said in asked if 0.1 * total < at < total]
    assert len(late) > 100
    for true, said in late:
        assert said is not None
        assert 1 / 1.5 < said / true < 1.5, f"{true:.0f} s before the end"
    assert progress.share == pytest.approx(1.0)
