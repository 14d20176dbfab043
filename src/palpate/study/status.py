"""Status of a study: artefacts in its result folder, by file names only."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from palpate.core import PalpateError, StoreContents, list_store
from palpate.study.plan import plan_study
from palpate.study.result import TaskFailure
from palpate.study.run_study import FAILURES, resolve_device
from palpate.study.study import Study
from palpate.study.task import Task

DEVICES = ("cpu", "cuda")


@dataclass(frozen=True)
class KindStatus:
    """Status of the artefacts of one kind.

    Attributes
    ----------
    made, total
        Numbers of existing and of needed artefacts.
    working, quarantined
        Numbers of artefacts that a process makes now, and that are broken.
    remaining_s
        Expected time on one core for the missing ones, s; only its order of magnitude matters.
    """

    made: int
    total: int
    working: int
    quarantined: int
    remaining_s: float


@dataclass(frozen=True)
class StudyStatus:
    """Status of a study.

    Attributes
    ----------
    kinds
        By kind of artefact, in the order in which they are made.
    failures
        Failures of the last completed run.
    """

    kinds: Mapping[str, KindStatus]
    failures: tuple[TaskFailure, ...]


def find_status(study: Study, out: Path) -> StudyStatus:
    """Find the status of `study` in the result folder `out`; nothing is written, no artefact opened.

    Raises
    ------
    PalpateError
        If a design cannot be built.
    """
    tasks = plan_study(resolve_device(study)).tasks()
    stored = list_store(out / "store")
    kinds: dict[str, list[Task]] = {}
    for task in tasks:
        kinds.setdefault(task.recipe.kind, []).append(task)
    return StudyStatus({kind: _count(kind, group, stored) for kind, group in kinds.items()}, _read_failures(out))


def needed_keys(studies: Iterable[Study]) -> frozenset[str]:
    """Return the keys of all artefacts that studies need, whatever the training device."""
    keys: set[str] = set()
    for study in studies:
        for device in DEVICES:
            learning = study.learning.model_copy(update={"device": device})
            keys.update(
                task.recipe.key for task in plan_study(study.model_copy(update={"learning": learning})).tasks()
            )
    return frozenset(keys)


def _count(kind: str, tasks: list[Task], stored: StoreContents) -> KindStatus:
    missing = [task for task in tasks if (kind, _file(task)) not in stored.artefacts]
    return KindStatus(
        made=len(tasks) - len(missing),
        total=len(tasks),
        working=sum((kind, task.recipe.key) in stored.working for task in missing),
        quarantined=sum((kind, f"{_file(task)}.broken") in stored.quarantined for task in tasks),
        remaining_s=sum(task.cost for task in missing),
    )


def _file(task: Task) -> str:
    return f"{task.recipe.key}{task.suffix}"


def _read_failures(out: Path) -> tuple[TaskFailure, ...]:
    path = out / FAILURES
    try:
        return tuple(TaskFailure(str(item["task"]), str(item["reason"])) for item in json.loads(path.read_text()))
    except FileNotFoundError:
        return ()
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise PalpateError(
            f"{path} cannot be read: {type(error).__name__}.", "Remove it and run again.", code="file-unreadable"
        ) from error
