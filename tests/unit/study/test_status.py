import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from errors import refused
from palpate.core import ArtefactStore
from palpate.core.run import Outcome
from palpate.study import Study, TaskFailure, find_status, needed_keys, run_study
from palpate.study.plan import plan_study
from palpate.study.run_study import Run
from palpate.study.task import Task

STUDY = Study.model_validate({"name": "a", "tilts_deg": [0, 2], "designs": {"markers": [7, 19]}})


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A result folder with one press of two, the other broken, and one dataset."""
    store = ArtefactStore(tmp_path / "store")
    tasks = [task for task in plan_study(STUDY).tasks() if task.recipe.kind in ("press", "dataset")]
    for task in tasks[:3]:
        store.write(task.recipe, lambda path: path.write_text("content") and None, task.suffix)
    store.path(tasks[1].recipe).write_text("conten")
    assert store.find(tasks[1].recipe) is None
    return tmp_path


def test_find_status_counts_what_is_made_broken_and_left(out: Path) -> None:
    kinds = find_status(STUDY, out).kinds
    assert (kinds["press"].made, kinds["press"].total, kinds["press"].quarantined) == (1, 2, 1)
    assert (kinds["dataset"].made, kinds["dataset"].total) == (1, 2)
    assert (kinds["learning"].made, kinds["learning"].total) == (0, 2)
    assert kinds["press"].remaining_s == pytest.approx(1.707629936490925)
    assert kinds["estimator"].remaining_s == 16.0
    assert find_status(STUDY, out).failures == ()


def test_find_status_names_what_is_at_work(out: Path) -> None:
    store = ArtefactStore(out / "store")
    press = next(task for task in plan_study(STUDY).tasks() if not store.has(task.recipe, task.suffix))
    with store.lease(press.recipe):
        assert find_status(STUDY, out).kinds["press"].working == 1
    assert find_status(STUDY, out).kinds["press"].working == 0


def test_find_status_tells_the_failures_of_the_last_run(out: Path) -> None:
    (out / "failures.json").write_text(json.dumps([{"task": "press", "reason": "too thin"}]))
    assert find_status(STUDY, out).failures == (TaskFailure("press", "too thin"),)


@pytest.mark.parametrize("text", ["", "[1]", '[{"task": 1}]', "{", "3"])
def test_failures_that_cannot_be_read_are_an_error_with_a_remedy(out: Path, text: str) -> None:
    (out / "failures.json").write_text(text)
    with refused("file-unreadable"):
        find_status(STUDY, out)


def test_needed_keys_are_those_of_every_study_on_every_device() -> None:
    keys = needed_keys([STUDY, STUDY.model_copy(update={"seed": 1})])
    plans = [plan_study(study) for study in (STUDY, STUDY.model_copy(update={"seed": 1}))]
    assert keys >= {task.recipe.key for plan in plans for task in plan.tasks()}
    cuda = STUDY.model_copy(update={"learning": STUDY.learning.model_copy(update={"device": "cuda"})})
    assert keys >= {task.recipe.key for task in plan_study(cuda).tasks()}
    assert needed_keys([]) == frozenset()


def test_a_run_tells_the_task_and_the_reason_of_each_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tasks that fail at once: in the result as in the file that the status reads."""

    def fail(run: Run, todo: Sequence[Task]) -> None:
        run.outcomes |= {task.recipe.key: Outcome(reason=f"{task.recipe.kind} too thin") for task in todo}

    monkeypatch.setattr(Run, "_do", fail)
    found = run_study(STUDY, tmp_path)
    tasks = plan_study(STUDY).tasks()
    wanted = {TaskFailure(task.name, f"{task.recipe.kind} too thin") for task in tasks if task.recipe.kind != "twin"}
    assert set(found.failures) == wanted
    assert wanted <= set(find_status(STUDY, tmp_path).failures)
    assert found.computed == {}
