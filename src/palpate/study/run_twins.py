"""Twins of a study's designs, and how good their units will be: presses, no training."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from palpate.built import BuiltFigure
from palpate.design import MarkerSpec, SkinSpec
from palpate.study.built_task import BuiltTask, read_figures
from palpate.study.observer import Observer, Silence
from palpate.study.plan import plan_study
from palpate.study.run_study import Hands, Run, writable
from palpate.study.study import BuiltSpec, Study
from palpate.study.task import find_made


@dataclass(frozen=True, eq=False)
class BuiltDesign:
    """A design's twin, and what its units will be.

    Attributes
    ----------
    skin, markers
        The design.
    twin
        File of the skin's twin; `None` where it could not be made.
    figures
        Without known presses, and with some; empty without a twin.
    problem
        Why there are none.
    """

    skin: SkinSpec
    markers: MarkerSpec
    twin: Path | None
    figures: tuple[BuiltFigure, ...]
    problem: str = ""


def run_twins(
    study: Study, out: Path, workers: int | None = None, observer: Observer | None = None
) -> tuple[BuiltDesign, ...]:
    """Press every skin of a study under all frictions, make its twin, and foresee its units.

    What an earlier run left in ``out/store`` is used. Parameters are those of `palpate.study.run_study`; without a
    ``built`` of its own the study takes that of `BuiltSpec`.

    Returns
    -------
    tuple[BuiltDesign, ...]
        One a design, in the order of the study.

    Raises
    ------
    PalpateError
        If a design cannot be built, or the folder cannot be written.
    """
    plan = plan_study(study.model_copy(update={"built": study.built or BuiltSpec()}))
    run = Run(writable(out), plan.built_tasks(), Hands(workers), observer or Silence())
    run.do()
    run.do_again((*plan.built, *{task.twin.recipe.key: task.twin for task in plan.built}.values()))
    run.write_failures()
    return tuple(_collect(run, task) for task in plan.built)


def _collect(run: Run, task: BuiltTask) -> BuiltDesign:
    reason = next((run.reason(each) for each in (*task.twin.presses, task.twin) if run.reason(each)), "")
    twin = None if reason else find_made(run.store, task.twin)
    reason = reason or run.reason(task)
    figures = () if reason else read_figures(find_made(run.store, task))
    return BuiltDesign(task.skin, task.markers, twin, figures, reason)
